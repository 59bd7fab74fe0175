// SPDX-License-Identifier: MIT
// Blind changes rarely keep the length of the header right, and then nothing behind it is reached.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace {

constexpr std::size_t kLengthBytes = 8;

using Bytes = std::vector<std::uint8_t>;

Bytes mutated(Bytes bytes, std::size_t most) {
    const std::size_t size = bytes.size();
    bytes.resize(std::max<std::size_t>(most, 1));
    bytes.resize(LLVMFuzzerMutate(bytes.data(), std::min(size, most), bytes.size()));
    return bytes;
}

}  // namespace

/// Changes the header or the data and sets the length to that of the header; now and then the bytes
/// as they are.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed) {
    if (size <= kLengthBytes || most < 2 * kLengthBytes || size > most || seed % 16 == 0) {
        return LLVMFuzzerMutate(data, size, most);
    }
    std::uint64_t length = 0;
    std::memcpy(&length, data, kLengthBytes);
    length = std::min<std::uint64_t>(length, size - kLengthBytes);
    std::uint8_t *const begin = data + kLengthBytes, *const middle = begin + length;
    Bytes header(begin, middle), rest(middle, data + size);
    if (seed % 4 == 1) {
        rest = mutated(std::move(rest), most - kLengthBytes - header.size());
        if (kLengthBytes + header.size() + rest.size() > most) rest.clear();
    } else {
        header = mutated(std::move(header), most - kLengthBytes - rest.size());
        if (kLengthBytes + header.size() + rest.size() > most) header.clear();
    }
    length = header.size();
    std::memcpy(data, &length, kLengthBytes);
    std::copy(header.begin(), header.end(), begin);
    std::copy(rest.begin(), rest.end(), begin + length);
    return kLengthBytes + header.size() + rest.size();
}
