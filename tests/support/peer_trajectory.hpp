// SPDX-License-Identifier: BSD-3-Clause
// Reader of the reference trajectories under tests/data/peer-liggghts.
#pragma once

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace culm::tests {

/// Lateral positions of some spheres over time.
struct PeerTrajectory {
    std::vector<int> spheres;                 ///< numbered from 0 at the clamp
    std::vector<double> times;                ///< s
    std::vector<std::vector<double>> lateral; ///< (times, spheres), m
};

inline PeerTrajectory read_peer_trajectory(const std::string& file) {
    std::ifstream in(file);
    if (!in)
        throw std::runtime_error(file + " is missing");
    PeerTrajectory trajectory;
    std::string line;
    std::getline(in, line);
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream header(line);
    std::string name;
    header >> name;
    while (header >> name) // z<number>_mm, numbered from 1
        trajectory.spheres.push_back(std::stoi(name.substr(1)) - 1);
    while (std::getline(in, line)) {
        std::replace(line.begin(), line.end(), ',', ' ');
        std::istringstream row(line);
        double time = 0.0;
        row >> time;
        trajectory.times.push_back(time);
        std::vector<double> values;
        double z = 0.0;
        while (row >> z)
            values.push_back(z * 1e-3);
        trajectory.lateral.push_back(values);
    }
    return trajectory;
}

} // namespace culm::tests
