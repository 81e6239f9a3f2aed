// SPDX-License-Identifier: BSD-3-Clause
#include "archive/study_results.hpp"

#include <algorithm>
#include <limits>

namespace culm::archive {

namespace {

/// The text in at most longest_failure_text bytes, never cut inside a UTF-8 character.
std::string shortened(const std::string& text) {
    if (text.size() <= longest_failure_text)
        return text;
    const std::string ellipsis = "…";
    std::size_t end = longest_failure_text - ellipsis.size();
    const auto continues_character = [](char c) {
        return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U;
    };
    while (end > 0 && continues_character(text[end]))
        --end;
    return text.substr(0, end) + ellipsis;
}

} // namespace

ResultsWriter::ResultsWriter(const Hdf5Output& output, const StudyDescription& description)
    : output_(output), group_(output.create_group(output.root(), "results")),
      table_(output, group_, description.results, static_cast<hsize_t>(description.points)),
      no_values_(description.results.size(), std::numeric_limits<double>::quiet_NaN()) {}

void ResultsWriter::append(const PointRecord* record) {
    const PointStatus status = record == nullptr ? PointStatus::Missing : record->status();
    statuses_.push_back(static_cast<std::uint8_t>(status));
    if (status == PointStatus::Failed) {
        failure_kinds_.emplace(statuses_.size() - 1, shortened(record->failure_kind));
        failure_reasons_.emplace(statuses_.size() - 1, shortened(record->failure_reason));
    }
    table_.append(status == PointStatus::Completed ? record->values : no_values_);
}

void ResultsWriter::finish() {
    const std::vector<hsize_t> shape{statuses_.size()};
    const std::vector<hsize_t> start{0};
    const DatatypeHandle type = status_type();
    const DatasetHandle status =
        output_.create_dataset(group_.get(), "status",
                               {type.get(),
                                shape,
                                {table_chunk_rows(shape[0])},
                                1,
                                "1",
                                "0: completed, 1: failed, 2: missing (not computed)"});
    output_.write_block(status, start, shape, type.get(), statuses_.data());
    write_texts("failure_kind", failure_kinds_, "short name of the kind of failure, else empty");
    write_texts("failure_reason", failure_reasons_, "why the point has no answer, else empty");
}

void ResultsWriter::write_texts(const std::string& name, const Texts& texts,
                                const std::string& description) {
    std::size_t width = 1;
    for (const auto& [row, text] : texts)
        width = std::max(width, text.size());
    constexpr std::size_t chunk_bytes = 65536;
    const hsize_t rows = statuses_.size();
    const hsize_t chunk = std::min<hsize_t>(rows, std::max<hsize_t>(1, chunk_bytes / width));
    const DatatypeHandle type = fixed_text_type(width);
    const DatasetHandle dataset = output_.create_dataset(
        group_.get(), name, {type.get(), {rows}, {chunk}, 1, "1", description});
    for (hsize_t begin = 0; begin < rows; begin += chunk) {
        const std::vector<hsize_t> start{begin};
        const std::vector<hsize_t> count{std::min(chunk, rows - begin)};
        std::string block(count[0] * width, '\0');
        const auto end = texts.lower_bound(begin + count[0]);
        for (auto text = texts.lower_bound(begin); text != end; ++text)
            std::ranges::copy(text->second, block.begin() + static_cast<std::ptrdiff_t>(
                                                                (text->first - begin) * width));
        output_.write_block(dataset, start, count, type.get(), block.data());
    }
}

} // namespace culm::archive
