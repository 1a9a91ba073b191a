// SPDX-License-Identifier: BSD-3-Clause
// HDF5 and MATLAB files that claim, or unpack to, a thousand times their size, or that point to
// other files: refused with a reason, in little memory, and nothing else is opened.
#include <gmock/gmock.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <zlib.h>

#include <functional>

#include "recording/arrays/broad.h"
#include "recording/files/hdf5_handle.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::HasSubstr;

constexpr std::size_t kRows = 200;
constexpr std::size_t kBombMegabytes = 1024;

// The most that the process has taken so far.
long peak_MB() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss / 1024;
}

// So many zero bytes, packed (a thousandth of them).
std::string packed_zeros(std::size_t bytes, const std::string& head = {}) {
  z_stream stream{};
  deflateInit(&stream, 9);
  std::string out, zeros(1 << 20, '\0'), room(1 << 16, '\0');
  const auto put = [&](std::string piece, int flush) {
    stream.next_in = reinterpret_cast<Bytef*>(piece.data());
    stream.avail_in = static_cast<uInt>(piece.size());
    do {
      stream.next_out = reinterpret_cast<Bytef*>(room.data());
      stream.avail_out = static_cast<uInt>(room.size());
      deflate(&stream, flush);
      out.append(room, 0, room.size() - stream.avail_out);
    } while (stream.avail_out == 0);
  };
  put(head, Z_NO_FLUSH);
  for (std::size_t left = bytes; left > 0;) {
    const std::size_t n = std::min(left, zeros.size());
    put(zeros.substr(0, n), Z_NO_FLUSH);
    left -= n;
  }
  put({}, Z_FINISH);
  deflateEnd(&stream);
  return out;
}

void write_dataset(hid_t file, const char* name, const std::vector<hsize_t>& dimensions,
                   hid_t layout = H5P_DEFAULT, bool values = true) {
  const int rank = static_cast<int>(dimensions.size());
  const Hdf5Handle space(H5Screate_simple(rank, dimensions.data(), nullptr), H5Sclose);
  const Hdf5Handle data(
      H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, layout, H5P_DEFAULT), H5Dclose);
  ASSERT_TRUE(data.ok());
  if (!values) return;
  std::vector<double> numbers(kRows * 3);
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<double>(i % 17);
  ASSERT_GE(H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()), 0);
}

const std::vector<hsize_t> kGoodShape = {kRows, 3};

// A good file, but that `imu_acc` is what the test makes of it.
class Hdf5Bomb : public testing::Test {
 protected:
  std::string write(const std::function<void(hid_t)>& imu_acc) {
    std::string path = folder_.path("bomb.h5");
    const Hdf5Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT),
                          H5Fclose);
    write_dataset(file, "imu_gyr", kGoodShape);
    write_dataset(file, "imu_mag", kGoodShape);
    const Hdf5Handle one(H5Screate(H5S_SCALAR), H5Sclose);
    const Hdf5Handle rate(
        H5Acreate2(file, "sampling_rate", H5T_NATIVE_DOUBLE, one, H5P_DEFAULT, H5P_DEFAULT),
        H5Aclose);
    const double hz = 50.0;
    H5Awrite(rate, H5T_NATIVE_DOUBLE, &hz);
    imu_acc(file);
    return path;
  }
  InputError error_of(const std::function<void(hid_t)>& imu_acc) {
    const std::string path = write(imu_acc);
    const long before = peak_MB();
    const InputError error = test::error_of([&] { read_hdf5(path); });
    EXPECT_LT(peak_MB() - before, 200);
    return error;
  }
  // Opening it would wait for ever.
  std::string fifo() {
    std::string path = folder_.path("fifo");
    ::mkfifo(path.c_str(), 0600);
    return path;
  }

  test::TempFolder folder_;
};

TEST_F(Hdf5Bomb, without_one_the_file_is_read) {
  const std::string path = write([](hid_t file) { write_dataset(file, "imu_acc", kGoodShape); });
  EXPECT_EQ(read_hdf5(path).acc.size(), kRows);
}

TEST_F(Hdf5Bomb, packed_chunks_and_soft_links_within_the_file_are_read) {
  const std::string path = write([](hid_t file) {
    const Hdf5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    const hsize_t chunk[] = {64, 2};
    H5Pset_chunk(layout, 2, chunk);
    H5Pset_shuffle(layout);
    H5Pset_deflate(layout, 6);
    H5Pset_fletcher32(layout);
    Hdf5Handle group(H5Gcreate2(file, "deep", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
    write_dataset(group, "there", kGoodShape, layout);
    H5Lcreate_soft("/deep/there", file, "imu_acc", H5P_DEFAULT, H5P_DEFAULT);
  });
  const Recording recording = read_hdf5(path);
  EXPECT_EQ(recording.acc.size(), kRows);
  EXPECT_EQ(recording.acc.v[1], Vector3(3, 4, 5));
}

TEST_F(Hdf5Bomb, external_links_are_not_opened) {
  const std::string other = fifo();
  InputError error = error_of([&](hid_t file) {
    H5Lcreate_external(other.c_str(), "/imu_acc", file, "imu_acc", H5P_DEFAULT, H5P_DEFAULT);
  });
  EXPECT_THAT(error.problem, HasSubstr("imu_acc lies in another file"));
  error = error_of([&](hid_t file) {
    H5Lcreate_external(other.c_str(), "/", file, "ext", H5P_DEFAULT, H5P_DEFAULT);
    H5Lcreate_soft("/ext/imu_acc", file, "imu_acc", H5P_DEFAULT, H5P_DEFAULT);
  });
  EXPECT_THAT(error.problem, HasSubstr("imu_acc lies in another file"));
}

TEST_F(Hdf5Bomb, external_and_virtual_storage_is_not_opened) {
  const std::string other = fifo();
  InputError error = error_of([&](hid_t file) {
    const Hdf5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_external(layout, other.c_str(), 0, kRows * 3 * sizeof(double));
    write_dataset(file, "imu_acc", kGoodShape, layout, false);
  });
  EXPECT_THAT(error.problem, HasSubstr("imu_acc lies in another file"));
  error = error_of([&](hid_t file) {
    const hsize_t now[] = {kRows, 3}, most[] = {H5S_UNLIMITED, 3}, start[] = {0, 0};
    const hsize_t count[] = {H5S_UNLIMITED, 1}, block[] = {1, 3};
    const Hdf5Handle space(H5Screate_simple(2, now, most), H5Sclose);
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, block);
    const Hdf5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    ASSERT_GE(H5Pset_virtual(layout, space, other.c_str(), "/imu_acc", space), 0);
    const Hdf5Handle data(
        H5Dcreate2(file, "imu_acc", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, layout, H5P_DEFAULT),
        H5Dclose);
    ASSERT_TRUE(data.ok());
  });
  EXPECT_THAT(error.problem, HasSubstr("imu_acc lies in another file"));
}

TEST_F(Hdf5Bomb, links_in_a_circle_lead_nowhere) {
  const InputError error = error_of([](hid_t file) {
    H5Lcreate_soft("/loop", file, "imu_acc", H5P_DEFAULT, H5P_DEFAULT);
    H5Lcreate_soft("/imu_acc", file, "loop", H5P_DEFAULT, H5P_DEFAULT);
  });
  EXPECT_THAT(error.problem, HasSubstr("imu_acc cannot be read"));
}

TEST_F(Hdf5Bomb, groups_within_groups_do_no_harm) {
  const std::string path = write([](hid_t file) {
    write_dataset(file, "imu_acc", kGoodShape);
    std::string name;
    for (int depth = 0; depth < 3000; ++depth) name += "/g";
    const Hdf5Handle make(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    H5Pset_create_intermediate_group(make, 1);
    const Hdf5Handle group(H5Gcreate2(file, name.c_str(), make, H5P_DEFAULT, H5P_DEFAULT),
                           H5Gclose);
    ASSERT_TRUE(group.ok());
  });
  EXPECT_EQ(read_hdf5(path).acc.size(), kRows);
}

TEST_F(Hdf5Bomb, dimensions_that_no_file_of_the_size_holds_are_refused) {
  for (const std::vector<hsize_t>& shape :
       {std::vector<hsize_t>{hsize_t(1) << 40, 3}, {hsize_t(1) << 32, hsize_t(1) << 31}}) {
    const InputError error = error_of([&](hid_t file) {
      const Hdf5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
      const hsize_t chunk[] = {1024, 3};
      H5Pset_chunk(layout, 2, chunk);
      write_dataset(file, "imu_acc", shape, layout, false);
    });
    EXPECT_THAT(error.problem, HasSubstr("more than the file can hold"));
    EXPECT_THAT(error.remedy, HasSubstr("damaged"));
  }
}

TEST_F(Hdf5Bomb, the_fields_of_a_file_share_its_room) {
  const std::string path = write([](hid_t file) {
    const Hdf5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    const hsize_t chunk[] = {1024, 3}, shape[] = {250'000, 3};
    H5Pset_chunk(layout, 2, chunk);
    for (const char* name : {"imu_gyr", "imu_mag"}) H5Ldelete(file, name, H5P_DEFAULT);
    for (const char* name : {"imu_acc", "imu_gyr", "imu_mag"}) {
      write_dataset(file, name, {shape[0], shape[1]}, layout, false);
    }
  });
  EXPECT_THAT(test::error_of([&] { read_hdf5(path); }).problem,
              HasSubstr("imu_gyr claims 250000 x 3 numbers, more than the file can hold"));
}

// A chunk of zeros of so many MB where the dataset says that it has `rows` rows.
void write_chunk_bomb(hid_t file, hsize_t rows) {
  const Hdf5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  const hsize_t chunk[] = {rows, 3}, now[] = {kRows, 3}, most[] = {H5S_UNLIMITED, 3};
  H5Pset_chunk(layout, 2, chunk);
  H5Pset_deflate(layout, 9);
  const Hdf5Handle space(H5Screate_simple(2, now, most), H5Sclose);
  const Hdf5Handle data(
      H5Dcreate2(file, "imu_acc", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, layout, H5P_DEFAULT),
      H5Dclose);
  const std::string zeros = packed_zeros(kBombMegabytes << 20);
  const hsize_t offset[] = {0, 0};
  ASSERT_GE(H5Dwrite_chunk(data, H5P_DEFAULT, 0, offset, zeros.size(), zeros.data()), 0);
}

// A chunk as h5py's lzf filter packs it: bytes as they are, then the same number again and again.
void write_lzf(hid_t file, const std::string& packed) {
  const Hdf5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  const hsize_t chunk[] = {kRows, 3};
  H5Pset_chunk(layout, 2, chunk);
  const unsigned values[] = {4, 0x0105, unsigned(kRows * 3 * sizeof(double))};
  H5Pset_filter(layout, 32000, H5Z_FLAG_OPTIONAL, 3, values);
  const Hdf5Handle space(H5Screate_simple(2, chunk, nullptr), H5Sclose);
  const Hdf5Handle data(
      H5Dcreate2(file, "imu_acc", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, layout, H5P_DEFAULT),
      H5Dclose);
  ASSERT_TRUE(data.ok());
  const hsize_t offset[] = {0, 0};
  ASSERT_GE(H5Dwrite_chunk(data, H5P_DEFAULT, 0, offset, packed.size(), packed.data()), 0);
}

std::string lzf_of_one_number(double value) {
  std::string packed(1, '\x07');  // eight bytes as they are
  packed.append(reinterpret_cast<const char*>(&value), sizeof value);
  std::size_t left = (kRows * 3 - 1) * sizeof(double);
  while (left > 0) {
    const std::size_t count = std::min<std::size_t>(left, 7 + 255 + 2);
    if (count < 9) {
      packed += char((count - 2) << 5);
    } else {
      packed += '\xE0';
      packed += char(count - 2 - 7);
    }
    packed += '\x07';  // eight bytes back
    left -= count;
  }
  return packed;
}

TEST_F(Hdf5Bomb, lzf_is_unpacked_and_what_is_damaged_refused) {
  const std::string packed = lzf_of_one_number(-2.5);
  const Recording r = read_hdf5(write([&](hid_t file) { write_lzf(file, packed); }));
  ASSERT_EQ(r.acc.size(), kRows);
  EXPECT_EQ(r.acc.v.front(), Vector3::Constant(-2.5));
  EXPECT_EQ(r.acc.v.back(), Vector3::Constant(-2.5));
  for (std::size_t n = 0; n < packed.size(); ++n) {
    std::string damaged = packed;
    damaged[n] = char(damaged[n] ^ 0x5A);
    for (const std::string& text : {damaged, packed.substr(0, n)}) {
      if (text.empty()) continue;
      try {
        read_hdf5(write([&](hid_t file) { write_lzf(file, text); }));
      } catch (const InputError&) {  // or other numbers
      }
    }
  }
}

TEST_F(Hdf5Bomb, a_chunk_larger_than_the_file_can_hold_is_refused) {
  const InputError error =
      error_of([](hid_t file) { write_chunk_bomb(file, (hsize_t(kBombMegabytes) << 20) / 24); });
  EXPECT_THAT(error.problem, HasSubstr("imu_acc claims chunks of numbers, more than"));
}

TEST_F(Hdf5Bomb, a_chunk_that_unpacks_to_more_than_it_says_is_refused) {
  const InputError error = error_of([](hid_t file) { write_chunk_bomb(file, 40'000); });
  EXPECT_THAT(error.problem, HasSubstr("imu_acc claims chunks of numbers, more than"));
}

TEST_F(Hdf5Bomb, other_filters_are_named_with_the_remedy) {
  const InputError error = error_of([](hid_t file) {
    const Hdf5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    const hsize_t chunk[] = {64, 3};
    H5Pset_chunk(layout, 2, chunk);
    H5Pset_deflate(layout, 9);
    H5Pset_deflate(layout, 9);
    write_dataset(file, "imu_acc", kGoodShape, layout);
  });
  EXPECT_THAT(error.problem, HasSubstr("imu_acc is packed in a way that is not read here"));
  EXPECT_THAT(error.remedy, HasSubstr("GZIP"));
}

TEST(ReadHdf5, a_pipe_is_refused_without_waiting_for_it) {
  const test::TempFolder folder;
  const std::string path = folder.path("fifo");
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  EXPECT_THAT(test::error_of([&] { read_hdf5(path); }).problem, HasSubstr("from a pipe"));
}

// --- MATLAB 5 ---

std::string number32(std::uint32_t value) { return {reinterpret_cast<char*>(&value), 4}; }

std::string element(std::uint32_t type, std::string data) {
  const auto size = static_cast<std::uint32_t>(data.size());
  data.resize((data.size() + 7) / 8 * 8);
  return number32(type) + number32(size) + data;
}

// What stands before the numbers of a packed matrix of doubles, and then so many bytes of zeros.
std::string packed_matrix(const std::string& name, std::uint32_t rows, std::uint32_t columns,
                          std::size_t zeros) {
  const std::uint32_t bytes = rows * columns * 8;
  const std::string parts = element(6, number32(6) + number32(0)) +
                            element(5, number32(rows) + number32(columns)) + element(1, name) +
                            number32(9) + number32(bytes);
  const std::string head =
      number32(14) + number32(static_cast<std::uint32_t>(parts.size()) + bytes) + parts;
  const std::string packed = packed_zeros(zeros, head);
  return number32(15) + number32(static_cast<std::uint32_t>(packed.size())) + packed;
}

std::string good_matrix(const std::string& name, const std::vector<double>& numbers) {
  const std::string bytes(reinterpret_cast<const char*>(numbers.data()), 8 * numbers.size());
  const auto columns = static_cast<std::uint32_t>(numbers.size() > 1 ? 3 : 1);
  const auto rows = static_cast<std::uint32_t>(numbers.size()) / columns;
  return element(14, element(6, number32(6) + number32(0)) +
                         element(5, number32(rows) + number32(columns)) + element(1, name) +
                         element(9, bytes));
}

class MatBomb : public testing::Test {
 protected:
  std::string write(const std::string& acc) {
    const std::vector<double> numbers(kRows * 3, 1.5);
    std::string head = "MATLAB 5.0 MAT-file";
    head.resize(124, ' ');
    return folder_.write(
        "bomb.mat", head + std::string("\0\1IM", 4) + acc + good_matrix("imu_gyr", numbers) +
                        good_matrix("imu_mag", numbers) + good_matrix("sampling_rate", {50.0}));
  }
  InputError error_of(const std::string& acc) {
    const std::string path = write(acc);
    const long before = peak_MB();
    const InputError error = test::error_of([&] { read_mat(path); });
    EXPECT_LT(peak_MB() - before, 200);
    return error;
  }
  test::TempFolder folder_;
};

constexpr std::uint32_t kBombRows = (kBombMegabytes << 20) / 24;

TEST_F(MatBomb, a_variable_that_claims_more_than_the_file_can_hold_is_refused) {
  const InputError error =
      error_of(packed_matrix("imu_acc", kBombRows, 3, std::size_t(kBombRows) * 24));
  EXPECT_THAT(error.problem, HasSubstr("more than the file can hold"));
}

TEST_F(MatBomb, one_that_unpacks_to_more_than_it_says_is_damaged) {
  const InputError error =
      error_of(packed_matrix("imu_acc", kRows, 3, std::size_t(kBombRows) * 24));
  EXPECT_THAT(error.problem, HasSubstr("imu_acc cannot be read as numbers"));
}

TEST_F(MatBomb, one_that_is_not_asked_for_is_not_unpacked) {
  const std::string acc = good_matrix("imu_acc", std::vector<double>(kRows * 3, 1.0));
  const std::string path =
      write(acc + packed_matrix("other", kBombRows, 3, std::size_t(kBombRows) * 24));
  const long before = peak_MB();
  EXPECT_EQ(read_mat(path).acc.size(), kRows);
  EXPECT_LT(peak_MB() - before, 200);
}

TEST_F(MatBomb, zeros_without_a_variable_are_damage) {
  const std::string packed = packed_zeros(kBombMegabytes << 20);
  const InputError error =
      error_of(number32(15) + number32(static_cast<std::uint32_t>(packed.size())) + packed);
  EXPECT_THAT(error.problem, HasSubstr("there is no field imu_acc"));
}

}  // namespace
}  // namespace magimu
