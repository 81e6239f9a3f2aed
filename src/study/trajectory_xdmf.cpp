// SPDX-License-Identifier: BSD-3-Clause
#include "study/trajectory_xdmf.hpp"

#include <cstddef>

#include <fmt/format.h>

namespace culm::study {
namespace {

std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
        if (c == '&')
            result += "&amp;";
        else if (c == '<')
            result += "&lt;";
        else
            result += c;
    }
    return result;
}

std::string connectivity(int spheres) {
    std::string text;
    for (int sphere = 0; sphere < spheres; ++sphere)
        text += fmt::format(" {}", sphere);
    return text;
}

} // namespace

std::string trajectory_xdmf(const std::string& archive, const std::string& group,
                            const archive::StudyDescription& description) {
    const std::size_t samples = description.times.size();
    const int spheres = description.spheres;
    std::string text = fmt::format("<?xml version=\"1.0\"?>\n<Xdmf Version=\"2.2\">\n<Domain>\n"
                                   "<Grid Name=\"{}\" GridType=\"Collection\" "
                                   "CollectionType=\"Temporal\">\n",
                                   escaped(group));
    for (std::size_t sample = 0; sample < samples; ++sample)
        text += fmt::format(
            "<Grid Name=\"stem\"><Time Value=\"{}\"/>\n"
            "<Topology TopologyType=\"Polyline\" NumberOfElements=\"1\" NodesPerElement=\"{}\">"
            "<DataItem Format=\"XML\" NumberType=\"Int\" Dimensions=\"1 {}\">{}</DataItem>"
            "</Topology>\n"
            "<Geometry GeometryType=\"XYZ\"><DataItem ItemType=\"HyperSlab\" Dimensions=\"{} 3\" "
            "Type=\"HyperSlab\"><DataItem Dimensions=\"3 3\" NumberType=\"Int\" Format=\"XML\">"
            "{} 0 0 1 1 1 1 {} 3</DataItem><DataItem Format=\"HDF\" NumberType=\"Float\" "
            "Precision=\"8\" Dimensions=\"{} {} 3\">{}:/particles/{}/position/value</DataItem>"
            "</DataItem></Geometry>\n</Grid>\n",
            description.times[sample], spheres, spheres, connectivity(spheres), spheres, sample,
            spheres, samples, spheres, escaped(archive), escaped(group));
    return text + "</Grid>\n</Domain>\n</Xdmf>\n";
}

} // namespace culm::study
