// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "temporary_names.h"

namespace mscomp {

/// A rename would replace a folder's or a device's entry, which nobody asks for with `-o`: IoError.
void refuse_special_target(const std::string& path);

/// A new file beside its target that takes the target's place when it is finished, and is removed
/// if it never does; if the process is killed, by the next that writes there. It has mode and owner
/// of a file that it replaces, and replaces what a link leads to. Every failure is an IoError with
/// the target's name and the system's reason.
class TemporaryFile {
  public:
    /// Throws IoError if the folder cannot be written or `target` is something else than a file;
    /// creates missing parent folders.
    explicit TemporaryFile(std::string target);
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    ~TemporaryFile();

    const std::string& target() const { return target_; }
    const std::string& path() const { return path_; }

    /// Makes the file `size` bytes long, zeros where nothing is written, and claims the room on the
    /// disk where the file system can do that: a disk that is too small then shows at once.
    void reserve(std::uint64_t size) const;
    /// Safe from several threads where the ranges differ.
    void write(std::uint64_t offset, std::span<const std::byte> bytes) const;
    /// As many bytes as there are from `offset` on, at most those of `bytes`.
    std::size_t read(std::uint64_t offset, std::span<std::byte> bytes) const;
    /// What was written reaches the disk.
    void sync() const;
    /// Renames it to its target and syncs the folder.
    void take_place();

    /// Throws the IoError that says that other bytes were read than had been written.
    [[noreturn]] void fail_comparison() const;

  private:
    std::string shown() const;
    [[noreturn]] void fail(std::string_view doing) const;

    std::string target_, path_;
    int descriptor_ = -1;
    std::optional<TemporaryName> name_;
};

}  // namespace mscomp
