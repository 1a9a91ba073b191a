// SPDX-License-Identifier: BSD-3-Clause
// MATLAB files written byte by byte, and by matio as somebody else's opinion: every type of number,
// both byte orders, what is no number, and damage at every place.
#include "recording/files/mat_file.h"

#include <gmock/gmock.h>
#include <matio.h>

#include <algorithm>
#include <bit>

#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::ElementsAre;
using testing::Optional;
using testing::SizeIs;

// Writes elements in the byte order asked for.
class Bytes {
 public:
  explicit Bytes(bool swapped) : swapped_(swapped) {}
  template <class T>
  Bytes& number(T value) {
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
    if (swapped_) std::reverse(bytes.begin(), bytes.end());
    text += bytes;
    return *this;
  }
  Bytes& element(std::uint32_t type, const std::string& data) {
    number(type).number(static_cast<std::uint32_t>(data.size()));
    text += data + std::string((8 - data.size() % 8) % 8, '\0');
    return *this;
  }
  std::string text;

 private:
  bool swapped_;
};

constexpr bool kLittle = std::endian::native == std::endian::little;

std::string file_of(const std::string& elements, bool swapped = false) {
  std::string head = "MATLAB 5.0 MAT-file";
  head.resize(126, ' ');
  return head + (kLittle != swapped ? "IM" : "MI") + elements;
}

template <class T>
std::string matrix(std::uint32_t kind, std::uint32_t type, std::uint32_t rows,
                   const std::vector<T>& values, bool swapped = false) {
  const auto columns = static_cast<std::uint32_t>(values.size()) / rows;
  Bytes numbers(swapped), parts(swapped), all(swapped);
  for (const T value : values) numbers.number(value);
  parts.element(6, Bytes(swapped).number(kind).number(0u).text);
  parts.element(5, Bytes(swapped).number(rows).number(columns).text);
  parts.element(1, "some_name").element(type, numbers.text);
  return all.element(14, parts.text).text;
}

TEST(MatFile, numbers_of_every_type_and_byte_order) {
  const auto read = [](auto first, std::uint32_t type) {
    using T = decltype(first);
    for (const bool swapped : {false, true}) {
      const std::string bytes =
          file_of(matrix<T>(6, type, 2, {first, T(2), T(3), T(100)}, swapped), swapped);
      const auto variables = mat_variables(bytes);
      ASSERT_TRUE(variables.whole) << type;
      ASSERT_THAT(variables.found, SizeIs(1));
      EXPECT_EQ(variables.found[0].name, "some_name");
      EXPECT_TRUE(variables.found[0].numeric);
      EXPECT_THAT(variables.found[0].dimensions, ElementsAre(2u, 2u));
      EXPECT_THAT(variables.found[0].numbers(),
                  Optional(ElementsAre(double(first), 2.0, 3.0, 100.0)))
          << type;
    }
  };
  read(std::int8_t(-1), 1);
  read(std::uint8_t(200), 2);
  read(std::int16_t(-300), 3);
  read(std::uint16_t(60000), 4);
  read(std::int32_t(-70000), 5);
  read(std::uint32_t(4'000'000'000), 6);
  read(0.25f, 7);
  read(-1e-300, 9);
  read(std::int64_t(-1) << 40, 12);
  read(std::uint64_t(1) << 63, 13);
}

TEST(MatFile, what_matio_writes) {
  const test::TempFolder folder;
  const std::string path = folder.path("several.mat");
  for (const matio_compression packing : {MAT_COMPRESSION_NONE, MAT_COMPRESSION_ZLIB}) {
    mat_t* file = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5);
    std::size_t two[] = {1, 2}, text_size[] = {1, 5};
    std::int16_t shorts[] = {-5, 7};
    float floats[] = {0.5f, -0.25f};
    char text[] = "hello";
    double real[] = {1, 2}, imaginary[] = {3, 4};
    mat_complex_split_t complex{real, imaginary};
    const char* fields[] = {"a"};
    std::size_t one[] = {1, 1};
    matvar_t* all[] = {
        Mat_VarCreate("s", MAT_C_INT16, MAT_T_INT16, 2, two, shorts, 0),
        Mat_VarCreate("text", MAT_C_CHAR, MAT_T_UTF8, 2, text_size, text, 0),
        Mat_VarCreate("c", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, two, &complex, MAT_F_COMPLEX),
        Mat_VarCreateStruct("struct", 2, one, fields, 1),
        Mat_VarCreate("a_longer_name", MAT_C_SINGLE, MAT_T_SINGLE, 2, two, floats, 0)};
    for (matvar_t* variable : all) {
      Mat_VarWrite(file, variable, packing);
      Mat_VarFree(variable);
    }
    Mat_Close(file);
    const std::string content = test::content_of(path);
    const auto [variables, whole] = mat_variables(content);
    ASSERT_TRUE(whole);
    ASSERT_THAT(variables, SizeIs(5));
    EXPECT_THAT(variables[0].numbers(), Optional(ElementsAre(-5, 7)));
    for (int i = 1; i < 4; ++i) EXPECT_FALSE(variables[std::size_t(i)].numeric) << i;
    EXPECT_EQ(variables[3].name, "struct");
    EXPECT_EQ(variables[4].name, "a_longer_name");
    EXPECT_THAT(variables[4].numbers(), Optional(ElementsAre(0.5, -0.25)));
  }
}

TEST(MatFile, cut_off_anywhere_is_seen_and_what_is_whole_before_is_found) {
  const std::string one = matrix<double>(6, 9, 1, {1, 2, 3}), whole = file_of(one + one);
  ASSERT_TRUE(mat_variables(whole).whole);
  const std::size_t second = 128 + one.size();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    if (length == second) continue;  // no file could tell
    const MatVariables variables = mat_variables(std::string_view(whole).substr(0, length));
    EXPECT_FALSE(variables.whole) << length;
    EXPECT_THAT(variables.found, SizeIs(length < second ? 0 : 1)) << length;
  }
}

// As MATLAB writes a serial port, a string, a table: no dimensions, the classes' names, and a
// matrix that refers to what MATLAB keeps elsewhere.
std::string object() {
  Bytes parts(false), all(false);
  parts.element(6, Bytes(false).number(17u).number(0u).text);
  parts.element(1, "port").element(1, "MCOS").element(1, "serial");
  parts.text += matrix<std::uint32_t>(13, 6, 1, {0xdd000000, 2, 1});
  return all.element(14, parts.text).text;
}

TEST(MatFile, objects_are_passed_over) {
  const std::string one = matrix<double>(6, 9, 1, {1, 2, 3});
  const std::string content = file_of(object() + one + object());
  const auto [variables, whole] = mat_variables(content);
  EXPECT_TRUE(whole);
  ASSERT_THAT(variables, SizeIs(3));
  EXPECT_EQ(variables[0].name, "port");
  EXPECT_FALSE(variables[0].numeric);
  EXPECT_THAT(variables[1].numbers(), Optional(ElementsAre(1, 2, 3)));
}

TEST(MatFile, claims_that_the_bytes_do_not_hold_are_damage) {
  const std::string good = file_of(matrix<double>(6, 9, 1, {1, 2, 3}));
  const auto with = [&](std::size_t at, std::uint32_t value) {
    return mat_variables(std::string(good).replace(at, 4, Bytes(false).number(value).text));
  };
  const std::size_t matrix_at = 128, dimensions_at = matrix_at + 8 + 16;
  ASSERT_TRUE(with(dimensions_at + 8, 1).whole);
  EXPECT_FALSE(with(matrix_at + 4, 0xFFFFFFFF).whole);      // longer than the file
  EXPECT_FALSE(with(dimensions_at + 4, 0xFFFFFFF0).whole);  // more dimensions than bytes
  EXPECT_FALSE(with(dimensions_at + 8, 0xFFFFFFFF).whole);  // more numbers than bytes
  EXPECT_FALSE(with(dimensions_at + 8, 0).whole);           // fewer
  EXPECT_FALSE(with(good.size() - 24 - 8, 8).whole);        // a type that does not exist
  EXPECT_FALSE(with(dimensions_at, 5u | 9u << 16).whole);   // a short one that is long
  EXPECT_FALSE(mat_variables(file_of(Bytes(false).element(15, "no zlib").text)).whole);
}

}  // namespace
}  // namespace magimu
