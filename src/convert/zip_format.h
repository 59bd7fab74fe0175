// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace mscomp::zip {

// Signatures and fixed lengths of the records of a zip archive.
inline constexpr std::uint32_t kLocalSignature = 0x04034b50;
inline constexpr std::uint32_t kDescriptorSignature = 0x08074b50;
inline constexpr std::uint32_t kCentralSignature = 0x02014b50;
inline constexpr std::uint32_t kEnd64Signature = 0x06064b50;
inline constexpr std::uint32_t kLocator64Signature = 0x07064b50;
inline constexpr std::uint32_t kEndSignature = 0x06054b50;

inline constexpr std::uint64_t kLocalLength = 30;
inline constexpr std::uint64_t kCentralLength = 46;
inline constexpr std::uint64_t kEnd64Length = 56;
inline constexpr std::uint64_t kLocator64Length = 20;
inline constexpr std::uint64_t kEndLength = 22;

inline constexpr std::uint16_t kStored = 0;
inline constexpr std::uint16_t kDeflated = 8;
inline constexpr std::uint16_t kEncryptedFlags = 0x2041;  // traditional, strong, masked header
inline constexpr std::uint16_t kDescriptorFlag = 0x0008;
inline constexpr std::uint16_t kExtra64 = 0x0001;
inline constexpr std::uint32_t kSee64 = 0xFFFFFFFF;
inline constexpr std::uint16_t kSee64Short = 0xFFFF;

}  // namespace mscomp::zip
