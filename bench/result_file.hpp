// SPDX-License-Identifier: BSD-3-Clause
// A file of bench/results: the cases for one question, and the commit that computed them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <fmt/core.h>
#include <generated/bench_commit.hpp>
#include <nlohmann/json.hpp>

namespace culm::bench {

/// Written after every case, so that a stopped run can continue. All cases are of
/// one commit: the constructor throws std::runtime_error if the file is of another.
class ResultFile {
  public:
    explicit ResultFile(std::filesystem::path file) : file_(std::move(file)) {
        if (std::ifstream stream(file_); stream)
            document_ = nlohmann::json::parse(stream);
        else
            document_ = {{"commit", commit}, {"cases", nlohmann::json::array()}};
        if (document_["commit"] != commit)
            throw std::runtime_error(
                fmt::format("{} was written by commit {}, this program is of {}: remove it first",
                            file_.string(), document_["commit"].get<std::string>(), commit));
    }

    [[nodiscard]] const nlohmann::json& cases() const { return document_["cases"]; }

    /// The keys that the file does not hold yet.
    [[nodiscard]] std::vector<nlohmann::json>
    missing(const std::vector<nlohmann::json>& keys) const {
        std::vector<nlohmann::json> wanted;
        for (const nlohmann::json& key : keys)
            if (!holds(key))
                wanted.push_back(key);
        return wanted;
    }

    /// Computes case_of(key) for the keys that the file does not hold yet, on `threads` threads,
    /// and calls print(case) for each. A key is the start of a case, for example {"number": 3}.
    /// No case is begun after `may_begin` returns false.
    template <class CaseOf, class Print>
    void add(
        const std::vector<nlohmann::json>& keys, const CaseOf& case_of, const Print& print,
        const std::function<bool()>& may_begin = [] { return true; },
        unsigned threads = std::thread::hardware_concurrency()) {
        const std::vector<nlohmann::json> wanted = missing(keys);
        std::mutex mutex;
        std::size_t next = 0;
        const auto work = [&] {
            std::unique_lock lock(mutex);
            while (next < wanted.size() && may_begin()) {
                const nlohmann::json key = wanted[next++];
                lock.unlock();
                nlohmann::json one = key;
                one.update(case_of(key));
                lock.lock();
                print(one);
                document_["cases"].push_back(std::move(one));
                write();
            }
        };
        std::vector<std::jthread> workers;
        for (unsigned k = 1; k < threads; ++k)
            workers.emplace_back(work);
        work();
    }

  private:
    [[nodiscard]] bool holds(const nlohmann::json& key) const {
        for (const nlohmann::json& one : cases()) {
            bool is_it = true;
            for (const auto& [name, value] : key.items())
                is_it = is_it && one.contains(name) && one[name] == value;
            if (is_it)
                return true;
        }
        return false;
    }

    void write() const {
        const std::filesystem::path part = file_.string() + ".part";
        std::ofstream(part) << document_.dump(1) << '\n';
        std::filesystem::rename(part, file_);
    }

    std::filesystem::path file_;
    nlohmann::json document_;
};

/// {"number": FIRST} … of COUNT cases, each with `common`.
inline std::vector<nlohmann::json> numbered(std::uint64_t first, std::uint64_t count,
                                            const nlohmann::json& common = {}) {
    std::vector<nlohmann::json> keys;
    for (std::uint64_t number = first; number < first + count; ++number) {
        nlohmann::json& key = keys.emplace_back(nlohmann::json{{"number", number}});
        if (!common.is_null())
            key.update(common);
    }
    return keys;
}

} // namespace culm::bench
