// SPDX-License-Identifier: BSD-3-Clause
#include "archive/trajectory/h5md.hpp"

#include <array>
#include <cstdint>

namespace culm::archive {

void write_h5md(const Hdf5Output& output, const StudyDescription& description) {
    const GroupHandle h5md = output.create_group(output.root(), "h5md");
    output.write_attribute(h5md.get(), "version", std::array<std::int32_t, 2>{1, 1});
    const GroupHandle author = output.create_group(h5md.get(), "author");
    output.write_attribute(author.get(), "name", std::string("culm"));
    const GroupHandle creator = output.create_group(h5md.get(), "creator");
    output.write_attribute(creator.get(), "name", std::string("culm"));
    output.write_attribute(creator.get(), "version", description.version);
}

GroupHandle create_histories(const Hdf5Output& output, const StudyDescription& description) {
    GroupHandle histories = output.create_group(output.root(), "histories");
    output.write_series(histories.get(), "time", "s", description.times);
    // H5MD requires step numbers and times for every trajectory.
    if (description.stored.positions)
        output.write_numbering(histories.get(), "step", description.times.size(),
                               "number of the sample, for the H5MD trajectories");
    return histories;
}

GroupHandle create_particle_group(const Hdf5Output& output, const std::string& path) {
    const GroupHandle group = output.create_group(output.root(), path);
    const GroupHandle box = output.create_group(group.get(), "box");
    output.write_attribute(box.get(), "dimension", std::array<std::int32_t, 1>{3});
    output.write_attribute(box.get(), "boundary",
                           std::array<std::string, 3>{"none", "none", "none"});
    GroupHandle position = output.create_group(group.get(), "position");
    output.link("/histories/step", position.get(), "step");
    output.link("/histories/time", position.get(), "time");
    return position;
}

DatasetLayout position_layout(const StudyDescription& description) {
    return {.type = description.single_precision ? H5T_IEEE_F32LE : H5T_IEEE_F64LE,
            .shape = {description.times.size(), static_cast<hsize_t>(description.spheres), 3},
            .chunk = {},
            .unit = "m",
            .description = "centres of the spheres: axial, lateral, out of plane"};
}

} // namespace culm::archive
