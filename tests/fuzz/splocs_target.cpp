// SPDX-License-Identifier: MIT
// HDF5's own reader is not hardened, so that what is made up here is not the bytes of a file but
// what a sound file holds: types, shapes, chunks, missing and other things in the place of data.
#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/temporary_folder.h"
#include "fuzz/promises.h"
#include "fuzz/shape_promises.h"
#include "fuzz/targets.h"
#include "mscomp/convert/splocs_file.h"

namespace mscomp::fuzz {
namespace {

/// The input, number by number; zeros behind its end.
class Numbers {
  public:
    explicit Numbers(std::span<const std::byte> bytes) : bytes_(bytes) {}

    unsigned next() {
        if (bytes_.empty()) return 0;
        const auto value = static_cast<unsigned>(bytes_.front());
        bytes_ = bytes_.subspan(1);
        return value;
    }
    /// Mostly small, now and then beyond everything.
    hsize_t length() {
        constexpr std::array<hsize_t, 4> kLarge{1U << 13, 1U << 31, hsize_t{1} << 40,
                                                hsize_t{1} << 62};
        const unsigned value = next();
        return value < 252 ? value % 12 : kLarge[value - 252];
    }

  private:
    std::span<const std::byte> bytes_;
};

hid_t type_of(unsigned choice) {
    const std::array<hid_t, 8> types{H5T_IEEE_F64LE, H5T_STD_I32LE, H5T_IEEE_F32BE, H5T_STD_I64LE,
                                     H5T_STD_U64BE,  H5T_STD_U8LE,  H5T_C_S1,       H5T_IEEE_F32LE};
    return types[choice % types.size()];
}

/// A data set of up to 4 axes whose data the input gives, as far as they are few.
void put_dataset(hid_t file, const char* name, Numbers& numbers) {
    constexpr hsize_t kMostWritten = 4096;
    const unsigned form = numbers.next();
    const hid_t type = type_of(form);
    const auto rank = static_cast<int>(form / 8 % 5);
    std::vector<hsize_t> lengths;
    hsize_t count = 1;
    for (int axis = 0; axis < rank; ++axis) {
        lengths.push_back(numbers.length());
        count *= std::min(lengths.back(), kMostWritten + 1);  // enough to tell
        count = std::min(count, kMostWritten + 1);
    }
    const hid_t space = rank > 0 ? H5Screate_simple(rank, lengths.data(), nullptr)
                                 : H5Screate(form >= 128 ? H5S_NULL : H5S_SCALAR);
    const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
    const bool is_written = count <= kMostWritten && type != H5T_C_S1;
    if (form >= 128 && rank > 0 && std::ranges::count(lengths, 0U) == 0) {
        std::vector<hsize_t> chunk;
        for (const hsize_t length : lengths) chunk.push_back(std::min<hsize_t>(length, 3));
        H5Pset_chunk(properties, rank, chunk.data());
        H5Pset_deflate(properties, 1);
    }
    const hid_t dataset = H5Dcreate2(file, name, type, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    if (dataset >= 0 && is_written) {
        std::vector<double> data(count);
        for (double& x : data) {
            const unsigned value = numbers.next();
            x = value == 255 ? std::nan("") : value == 254 ? 1e300 : value % 16;
        }
        H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data());
    }
    if (dataset >= 0) H5Dclose(dataset);
    H5Pclose(properties);
    H5Sclose(space);
}

/// What stands under the name: mostly a data set.
void put(hid_t file, const char* name, Numbers& numbers) {
    switch (numbers.next() % 8) {
        case 6:
            return;
        case 7:
            H5Gclose(H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
            return;
        default:
            put_dataset(file, name, numbers);
    }
}

void put_file(const std::string& path, std::span<const std::byte> input) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    Numbers numbers(input);
    put(file, "verts", numbers);
    put(file, "tris", numbers);
    H5Fclose(file);
}

}  // namespace

void check_splocs(std::span<const std::byte> input) {
    static const TemporaryFolder folder;
    const std::string path = folder / "input.h5";
    put_file(path, input);
    const auto contents = unless_refused(path, [&] {
        Contents read = read_splocs(path);
        check_sound(*read.shapes);
        return read;
    });
    if (!contents) return;
    const std::string again = folder / "again.h5";
    write_splocs(again, *contents->shapes);
    check_same(*read_splocs(again).shapes, *contents->shapes);
}

}  // namespace mscomp::fuzz
