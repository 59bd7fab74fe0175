// SPDX-License-Identifier: MIT
#include "base/temporary_folder.h"
#include "fuzz/promises.h"
#include "fuzz/targets.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/convert/zip.h"

namespace mscomp::fuzz {
namespace {

struct File {
    std::string name, content;
};

std::vector<File> unpacked(std::span<const std::byte> archive, const std::string& path) {
    std::vector<File> files;
    for (const ZipEntry& entry : read_zip_entries(archive, path)) {
        std::vector<std::byte> storage;
        files.push_back({entry.name, std::string(text_of(unpack(entry, path, storage)))});
        require(files.back().content.size() == entry.size, "a file has the size it declares");
    }
    return files;
}

}  // namespace

void check_zip(std::span<const std::byte> input) {
    const auto files = unless_refused("input", [&] { return unpacked(input, "input"); });
    if (!files) return;
    static const TemporaryFolder folder;
    const std::string path = folder / "archive.zip";
    AtomicFile file(path);
    ZipWriter writer(file);
    for (const File& one : *files) {
        writer.begin_file(one.name);
        writer.write(std::string_view(one.content));
    }
    writer.finish();
    file.commit();
    const std::string archive = read_file(path);
    const std::vector<File> again = unpacked(bytes_of(archive), path);
    require(std::equal(again.begin(), again.end(), files->begin(), files->end(),
                       [](const File& a, const File& b) {
                           return a.name == b.name && a.content == b.content;
                       }),
            "an archive survives writing and reading");
}

}  // namespace mscomp::fuzz
