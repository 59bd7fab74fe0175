// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

namespace mscomp::nn {

/// Zero pages of the system. One takes up memory from when it is first written to.
class ZeroPages {
  public:
    ZeroPages() = default;
    ZeroPages(ZeroPages&& other) noexcept
        : start_(std::exchange(other.start_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}
    ZeroPages& operator=(ZeroPages&& other) noexcept {
        std::swap(start_, other.start_);
        std::swap(bytes_, other.bytes_);
        return *this;
    }
    ~ZeroPages();

    void* start() const { return start_; }
    /// At least `bytes`, with what they hold; may move. Throws std::bad_alloc.
    void grow(std::size_t bytes);
    /// All zero again, and none of them takes up memory. Throws std::bad_alloc.
    void reset();
    /// The bytes [first, last) zero again; whole pages among them take up no memory. Throws
    /// std::bad_alloc.
    void reset(std::size_t first, std::size_t last);

  private:
    void* start_ = nullptr;
    std::size_t bytes_ = 0;
};

/// An array of zeros whose parts take up memory only from when they are written to, so that one of
/// which little is used costs little. Starts on a page, and thus on a cache line.
template <class T>
class ZeroedArray {
    static_assert(std::is_trivially_copyable_v<T>);

  public:
    ZeroedArray() = default;
    ZeroedArray(ZeroedArray&& other) noexcept
        : pages_(std::move(other.pages_)), size_(std::exchange(other.size_, 0)) {}
    ZeroedArray& operator=(ZeroedArray&& other) noexcept {
        std::swap(pages_, other.pages_);
        std::swap(size_, other.size_);
        return *this;
    }
    ~ZeroedArray() = default;

    std::size_t size() const { return size_; }
    T* data() { return static_cast<T*>(pages_.start()); }
    const T* data() const { return static_cast<const T*>(pages_.start()); }
    T* begin() { return data(); }
    T* end() { return data() + size_; }
    const T* begin() const { return data(); }
    const T* end() const { return data() + size_; }

    /// Makes room for `size` elements, no fewer than there are; those there keep their value, the
    /// others are zero. Pointers taken before become invalid. Throws std::bad_alloc.
    void grow(std::size_t size) {
        pages_.grow(size * sizeof(T));
        size_ = size;
    }
    /// Sets all to zero and gives their memory back. Pointers stay valid. Throws std::bad_alloc.
    void reset() { pages_.reset(); }
    /// The same for elements [first, last).
    void reset(std::size_t first, std::size_t last) {
        pages_.reset(first * sizeof(T), last * sizeof(T));
    }

  private:
    ZeroPages pages_;
    std::size_t size_ = 0;
};

}  // namespace mscomp::nn
