// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target: a study's journal. The first byte chooses: the bytes of a journal file, the bytes
// after a whole file header, the payload of a record whose checksums are right, or the note next to
// the journals.
#include "archive/bytes.hpp"
#include "archive/journal/format.hpp"
#include "archive/journal/read.hpp"
#include "core/wire.hpp"
#include "fuzz/fuzz_input.hpp"
#include "study/execute/folder_state.hpp"

#include <span>

namespace {

using namespace culm;

constexpr const char* identity = "study.seed = 1\n";

void append(std::string& bytes, std::span<const std::byte> more) {
    bytes.append(reinterpret_cast<const char*>(more.data()), more.size());
}

/// A record as archive::encode_record writes it, with any payload.
std::string record_with(std::string_view payload) {
    core::WireWriter header;
    header(archive::record_magic, std::uint64_t{payload.size()}, std::int64_t{3},
           static_cast<std::uint32_t>(archive::RecordKind::Completed), std::uint32_t{0},
           archive::crc32(payload));
    const core::Bytes bytes = header.take();
    std::string record;
    append(record, bytes);
    append(record, core::encoded(archive::crc32(bytes)));
    return record.append(payload);
}

std::string journal_of(std::uint8_t choice, const std::string& input) {
    if (choice % 4 == 0)
        return input;
    std::string journal;
    append(journal, archive::encode_journal_header(identity));
    return journal + (choice % 4 == 1 ? input : record_with(input));
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0)
        return 0;
    const std::string input = fuzz::text_of(data + 1, size - 1);
    const study::StudyFolder folder(fuzz::folder());
    std::filesystem::create_directories(folder.journals());
    const std::filesystem::path file = folder.journal_of_rank(0);
    std::filesystem::remove(folder.note());
    std::filesystem::remove(file);
    if (data[0] % 4 == 3)
        fuzz::write("journal/study.json", input);
    else
        fuzz::write("journal/" + file.filename().string(), journal_of(data[0], input));
    fuzz::may_refuse(
        [&] { static_cast<void>(read_folder_state(folder, study::FolderDepth::Verify)); });
    fuzz::may_refuse([&] {
        archive::JournalIndex index(archive::scan_journal_folder(folder.journals(), identity));
        for (std::int64_t point = -1; point < 5; ++point)
            static_cast<void>(index.find_record(point));
    });
    return 0;
}
