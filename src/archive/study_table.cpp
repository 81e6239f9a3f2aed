// SPDX-License-Identifier: BSD-3-Clause
#include "archive/study_table.hpp"

namespace culm::archive {

TableWriter::TableWriter(const Hdf5Output& output, const GroupHandle& group,
                         std::span<const Column> columns, hsize_t rows)
    : output_(output), rows_(rows), chunk_rows_(table_chunk_rows(rows)), buffers_(columns.size()) {
    std::vector<std::string> names;
    for (const Column& column : columns) {
        names.push_back(column.name);
        datasets_.push_back(output.create_dataset(
            group.get(), column.name,
            {H5T_IEEE_F64LE, {rows}, {chunk_rows_}, 1, column.unit, column.description}));
    }
    if (!names.empty()) // an attribute cannot be empty in a way that every reader understands
        output.write_attribute(group.get(), "columns", names);
}

void TableWriter::append(std::span<const double> row) {
    for (std::size_t column = 0; column < buffers_.size(); ++column)
        buffers_[column].push_back(row[column]);
    ++buffered_;
    if (buffered_ == chunk_rows_ || written_ + buffered_ == rows_)
        flush();
}

void TableWriter::flush() {
    const std::vector<hsize_t> start{written_};
    const std::vector<hsize_t> count{buffered_};
    for (std::size_t column = 0; column < buffers_.size(); ++column) {
        output_.write_block(datasets_[column], start, count, H5T_NATIVE_DOUBLE,
                            buffers_[column].data());
        buffers_[column].clear();
    }
    written_ += buffered_;
    buffered_ = 0;
}

} // namespace culm::archive
