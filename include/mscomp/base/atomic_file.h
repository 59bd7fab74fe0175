// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace mscomp {

/// A file that appears whole or not at all: written beside its target under a temporary name, then
/// flushed, fsynced, read back and compared (XXH3), renamed, and its folder fsynced. Without
/// commit() nothing is left behind.
class AtomicFile {
  public:
    /// Throws IoError if the folder cannot be written or `path` is something else than a file;
    /// creates missing parent folders.
    explicit AtomicFile(std::string path);
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;
    ~AtomicFile();

    /// Throws IoError with the system's reason (disk full, ...).
    void write(std::span<const std::byte> bytes);
    void write(std::string_view text);
    /// Called on the finished temporary file before it is renamed; throw there to refuse it.
    using Check = std::function<void(const std::string& temporary_path)>;
    /// Makes the file appear under its name. Throws IoError; the earlier file then still stands.
    void commit(const Check& check = {});

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Writes `text` to `path` as one atomic step. Throws IoError.
void write_file(const std::string& path, std::string_view text);
/// The whole content of `path`. Throws IoError.
std::string read_file(const std::string& path);

}  // namespace mscomp
