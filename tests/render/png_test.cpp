// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "mscomp/base/error.h"
#include "mscomp/base/random.h"
#include "mscomp/render/render.h"

#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#include <stb_image.h>

namespace mscomp {
namespace {

Image noise(int width, int height) {
    Image image{width, height, {}};
    const CounterRandom random(3, 0);
    for (int i = 0; i < width * height * 3; ++i) {
        image.rgb.push_back(static_cast<std::uint8_t>(random.bits(static_cast<std::uint64_t>(i))));
    }
    return image;
}

// What an independent decoder reads is what was written, bit for bit.
TEST(WritePng, IsReadBackAsItWas) {
    const std::string path = testing::TempDir() + "mscomp_png_test/noise.png";
    const Image image = noise(37, 23);
    write_png(path, image);
    int width = 0, height = 0, channels = 0;
    unsigned char* decoded = stbi_load(path.c_str(), &width, &height, &channels, 0);
    ASSERT_NE(decoded, nullptr);
    EXPECT_EQ(width, 37);
    EXPECT_EQ(height, 23);
    ASSERT_EQ(channels, 3);
    EXPECT_TRUE(std::equal(image.rgb.begin(), image.rgb.end(), decoded));
    stbi_image_free(decoded);
    std::filesystem::remove_all(testing::TempDir() + "mscomp_png_test");
}

TEST(WritePng, RefusesAPictureWithoutPixels) {
    const std::string path = testing::TempDir() + "mscomp_no_picture.png";
    EXPECT_THROW(write_png(path, Image{}), UsageError);
    EXPECT_THROW(write_png(path, Image{2, 2, {1, 2, 3}}), UsageError);
    EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(WritePng, SaysWhichFileCannotBeWritten) {
    try {
        write_png("/proc/no_such_place/picture.png", noise(2, 2));
        FAIL() << "nothing was thrown";
    } catch (const IoError& error) {
        EXPECT_NE(std::string(error.what()).find("picture.png"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace mscomp
