// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cstdlib>
#include <new>

#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/render/render.h"

namespace {

/// It writes to what it asks for without a look whether there was any.
void* there(void* memory) {
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

}  // namespace

#define STBIW_MALLOC(size) there(std::malloc(size))
#define STBIW_REALLOC(memory, size) there(std::realloc(memory, size))
#define STBIW_FREE(memory) std::free(memory)
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>

namespace mscomp {

void write_png(const std::string& path, const Image& image) {
    const auto size = at(image.width) * at(image.height) * 3;
    if (image.width <= 0 || image.height <= 0 || image.rgb.size() != size) {
        throw UsageError(fmt::format("{}: a picture of {} x {} pixels with {} bytes, wanted {}",
                                     path, image.width, image.height, image.rgb.size(), size));
    }
    std::string bytes;
    const auto append = [](void* context, void* data, int count) {
        static_cast<std::string*>(context)->append(static_cast<const char*>(data), at(count));
    };
    if (stbi_write_png_to_func(append, &bytes, image.width, image.height, 3, image.rgb.data(),
                               image.width * 3) == 0) {
        throw IoError(path, "the picture could not be compressed");
    }
    write_file(path, bytes);
}

}  // namespace mscomp
