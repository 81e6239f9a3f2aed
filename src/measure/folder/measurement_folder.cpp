// SPDX-License-Identifier: BSD-3-Clause
#include "measure/folder/measurement_folder.hpp"

#include "core/error.hpp"
#include "core/user_files.hpp"
#include "measure/folder/measurement_files.hpp"
#include "measure/release/swing_release.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

namespace culm::measure {

namespace {

namespace fs = std::filesystem;

bool is_measurement(const fs::path& folder) {
    return fs::is_regular_file(folder / deflection_file_name);
}

/// Reads a table with the times and heights of deflection.csv.
void read_uncertainties(const fs::path& file, Measurement& measurement) {
    Measurement table = measurement;
    table.times.clear();
    table.heights.clear();
    table.deflections.clear();
    table.noise_by_height.clear();
    read_deflection_file(file, table);
    if (table.times != measurement.times || table.heights != measurement.heights)
        throw core::InputError(fmt::format("{}: times and heights must be those of {}",
                                           file.string(), deflection_file_name));
    for (std::size_t at = 0; at < table.deflections.size(); ++at)
        if (!std::isnan(measurement.deflections[at]) && !(table.deflections[at] > 0.0))
            throw core::InputError(fmt::format(
                "{}: {} at {:g} s and {:g} mm: every reading needs a standard uncertainty above 0",
                file.string(),
                std::isnan(table.deflections[at])
                    ? "nothing"
                    : fmt::format("{:g} mm", 1e3 * table.deflections[at]),
                table.times[at / table.heights.size()],
                1e3 * table.heights[at % table.heights.size()]));
    measurement.reading_uncertainties = std::move(table.deflections);
}

/// The time of the largest reading, if the stem hardly moves in the period at the beginning of the
/// record: then it is not yet free there.
std::optional<double> late_release(const Measurement& measurement) {
    constexpr double quiet = 0.5; // of the largest reading
    const auto& times = measurement.times;
    std::vector<double> history;
    std::size_t peak = 0;
    double largest = 0.0;
    for (std::size_t j = 0; j < measurement.heights.size(); ++j) {
        std::vector<double> row = measurement.history(j);
        const double centre = centre_of_swing(times, row, times.front());
        for (double& reading : row)
            reading = (reading - centre) * measurement.heights[j]; // the upper row where equal
        const auto top = std::ranges::max_element(
            row, {}, [](double reading) { return std::isnan(reading) ? 0.0 : std::abs(reading); });
        if (std::abs(*top) > largest) {
            largest = std::abs(*top);
            peak = static_cast<std::size_t>(top - row.begin());
            history = std::move(row);
        }
    }
    std::vector<double> passages;
    for (std::size_t i = peak + 1; i < history.size(); ++i)
        if (history[i - 1] * history[i] < 0.0)
            passages.push_back(times[i]);
    if (passages.size() < 4)
        return std::nullopt;
    const double end = times.front() + mean_period(passages);
    for (std::size_t i = 0; i < history.size() && times[i] < end; ++i)
        if (i == peak || std::abs(history[i]) > quiet * largest)
            return std::nullopt;
    return times[peak];
}

/// Removes the frames before the start, which becomes time 0.
void begin_at_start(const fs::path& folder, Measurement& measurement) {
    if (measurement.start == 0.0) { // none is stated
        measurement.start = std::max(0.0, measurement.times.front());
        if (const auto late = late_release(measurement); late && *late > measurement.start) {
            measurement.start = *late;
            measurement.remarks.push_back(fmt::format(
                "{}: the stem is not free at the beginning of the record; the readings before the "
                "largest one, at {:.4g} s, are left out ([release] start_s states another start)",
                folder.string(), *late));
        }
    }
    const auto first = std::ranges::lower_bound(measurement.times, measurement.start);
    const auto before = first - measurement.times.begin();
    if (measurement.times.end() - first < 2)
        throw core::InputError(fmt::format(
            "{}: [release] start_s = {:g} leaves {} frames of {}; the last time is {:g} s",
            (folder / stem_file_name).string(), measurement.start, measurement.times.end() - first,
            measurement.times.size(), measurement.times.back()));
    measurement.times.erase(measurement.times.begin(), first);
    const auto readings = before * static_cast<std::ptrdiff_t>(measurement.heights.size());
    for (std::vector<double>* table :
         {&measurement.deflections, &measurement.reading_uncertainties})
        if (!table->empty())
            table->erase(table->begin(), table->begin() + readings);
    for (double& time : measurement.times)
        time -= measurement.start;
    measurement.start = 0.0;
}

/// Removes from each sensor's column the centre of its swing, unless the uncertainty of its zero
/// is stated. The constant error that remains is a parameter of every fit.
void remove_offsets(const fs::path& folder, Measurement& measurement) {
    for (std::size_t j = 0; j < measurement.sensors.size(); ++j) {
        const Sensor& sensor = measurement.sensors[j];
        if (sensor.is_camera() || sensor.offset_uncertainty)
            continue;
        const double offset = centre_of_swing(measurement.times, measurement.history(j), 0.0);
        for (std::size_t i = 0; i < measurement.times.size(); ++i)
            measurement.deflections[i * measurement.heights.size() + j] -= offset;
        const double unit = unit_size(sensor.quantity, sensor.unit).value_or(1.0);
        measurement.remarks.push_back(
            fmt::format("{}: the centre of column \"{}\", {:.4g} {}, was removed", folder.string(),
                        sensor.column, offset / unit, sensor.unit));
    }
}

} // namespace

Measurement read_measurement(const fs::path& folder) {
    if (!fs::is_directory(folder))
        throw core::InputError(
            fmt::format("{}: there is no such folder (a measurement is a folder with {} and {})",
                        folder.string(), stem_file_name, deflection_file_name));
    for (const char* name : {stem_file_name, deflection_file_name})
        if (!fs::is_regular_file(folder / name))
            throw core::InputError(fmt::format("{}: there is no {}", folder.string(), name));
    Measurement measurement = read_stem_file(folder / stem_file_name);
    read_deflection_file(folder / deflection_file_name, measurement);
    if (fs::is_regular_file(folder / uncertainty_file_name))
        read_uncertainties(folder / uncertainty_file_name, measurement);
    if (measurement.release == ReleaseKind::Moving)
        begin_at_start(folder, measurement);
    remove_offsets(folder, measurement);
    if (const std::string doubt = doubt_of_zero(measurement, false); !doubt.empty())
        measurement.remarks.push_back(fmt::format("{}: {}", folder.string(), doubt));
    return measurement;
}

void write_measurement(const fs::path& folder, const Measurement& measurement) {
    core::create_folder(folder);
    core::write_text(folder / stem_file_name, stem_file_text(measurement));
    core::write_text(folder / deflection_file_name, deflection_file_text(measurement));
    if (measurement.reading_uncertainties.empty()) {
        std::error_code ignored;
        fs::remove(folder / uncertainty_file_name, ignored); // of an earlier measurement
    } else {
        Measurement uncertainties = measurement;
        uncertainties.deflections = measurement.reading_uncertainties;
        core::write_text(folder / uncertainty_file_name, deflection_file_text(uncertainties));
    }
    static_cast<void>(read_measurement(folder));
}

std::vector<fs::path> find_measurements(const fs::path& path) {
    if (is_measurement(path))
        return {path};
    if (!fs::is_directory(path))
        throw core::InputError(fmt::format("{}: there is no such folder", path.string()));
    std::vector<fs::path> found;
    for (const fs::directory_entry& entry : fs::directory_iterator(path))
        if (entry.is_directory() && is_measurement(entry.path()))
            found.push_back(entry.path());
    std::ranges::sort(found);
    if (found.empty())
        throw core::InputError(fmt::format(
            "{}: neither this folder nor a folder in it holds a {}{}", path.string(),
            deflection_file_name,
            fs::exists(path / "video.toml") ? " (`culm track` makes one from video.toml)" : ""));
    return found;
}

MeasurementSet read_measurements(const std::vector<std::string>& paths) {
    MeasurementSet set;
    std::string faults;
    for (const std::string& path : paths)
        for (const std::filesystem::path& folder : find_measurements(path)) {
            try {
                set.measurements.push_back(read_measurement(folder));
                set.folders.push_back(folder);
            } catch (const core::InputError& error) {
                faults += (faults.empty() ? "" : "\n") + std::string(error.what());
            }
        }
    if (!faults.empty())
        throw core::InputError(faults);
    return set;
}

} // namespace culm::measure
