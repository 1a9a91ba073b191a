// SPDX-License-Identifier: BSD-3-Clause
// A raw sample through each target's own formula, with the numbers of the exported file and nothing
// else, is our corrected sample to 1e-6 (uT, m/s^2, rad/s).
#include "calibration/use/export.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cstdlib>
#include <map>
#include <random>
#include <regex>
#include <sstream>

#include "calibration/use/applied_json.h"
#include "calibration/use/apply.h"
#include "recording/data/axes.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using Numbers = std::map<std::string, double>;

constexpr double kSame = 1e-6;

// The magnetometers stand at an angle to the IMU, unless their matrix is to be symmetric.
Calibration example(int magnetometers = 1, bool symmetric = false) {
  Calibration c;
  c.parameters.acc_bias = Vector3(0.11, -0.052, 0.031);
  c.parameters.gyr_bias = Vector3(0.0123, -0.0045, 0.0067);
  c.parameters.dip_rad = 1.1;
  c.parameters.mag.clear();
  for (int m = 0; m < magnetometers; ++m) {
    Matrix3 soft;
    soft << 52.0, 2.0, -1.5, 2.0, 47.0, 0.8, -1.5, 0.8, 49.0;
    const Matrix3 turn =
        Eigen::AngleAxisd(symmetric ? 0.0 : 0.3 + m, Vector3(1.0, -2.0, 0.5).normalized())
            .toRotationMatrix();
    c.parameters.mag.push_back({soft * turn, Vector3(31.0 + m, -12.0, 77.0)});
    c.mag_names.push_back(magnetometers == 1 ? "mag" : "mag" + std::to_string(m + 1));
  }
  c.strength_uT = std::cbrt(c.parameters.mag[0].distortion.determinant());
  ActiveEffect gyr{"gyro_scale_misalignment", {}};
  gyr.parameters = {{"gyroscope.scale_misalignment[0][0]", "1", 0.011},
                    {"gyroscope.scale_misalignment[1][0]", "1", -0.004},
                    {"gyroscope.scale_misalignment[2][2]", "1", 0.02}};
  c.effects = {{"mag_time_offset", {{"magnetometers[0].time_offset_s", "s", 0.011}}}, gyr};
  return c;
}

// As calibrate() finds it on boards.
void add_acc_matrix(Calibration& c) {
  ActiveEffect acc{"acc_scale_misalignment", {}};
  const double L[] = {0.011, 0.004, -0.012, -0.006, 0.009, 0.021};
  for (const double entry : L) acc.parameters.push_back({"effects.acc", "1", entry});
  c.effects.push_back(acc);
}
Vector3 corrected_acc(const Calibration& c, const Vector3& raw) {
  return (Matrix3::Identity() + acc_scale_misalignment(c)).inverse() *
         (raw - c.parameters.acc_bias);
}

std::vector<Vector3> samples(double size) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, size);
  std::vector<Vector3> out(50);
  for (Vector3& v : out) v = Vector3(normal(random), normal(random), normal(random));
  return out;
}

Vector3 xyz(const Numbers& n, const std::string& before, const std::string& after = "") {
  return {n.at(before + "X" + after), n.at(before + "Y" + after), n.at(before + "Z" + after)};
}

Matrix3 symmetric(const Vector3& diagonal, const Vector3& off) {
  Matrix3 S;
  S << diagonal[0], off[0], off[1], off[0], diagonal[1], off[2], off[1], off[2], diagonal[2];
  return S;
}

Matrix3 rotation(double roll_deg, double pitch_deg, double yaw_deg) {
  return (Eigen::AngleAxisd(yaw_deg * kDegree, Vector3::UnitZ()) *
          Eigen::AngleAxisd(pitch_deg * kDegree, Vector3::UnitY()) *
          Eigen::AngleAxisd(roll_deg * kDegree, Vector3::UnitX()))
      .toRotationMatrix();
}

// The rotation that a sentence about what is lost states.
Matrix3 stated_rotation(const std::string& sentence) {
  std::smatch found;
  const std::regex pattern("roll ([-.0-9e]+), pitch ([-.0-9e]+), yaw ([-.0-9e]+)");
  if (!std::regex_search(sentence, found, pattern)) ADD_FAILURE() << sentence;
  return rotation(std::stod(found[1]), std::stod(found[2]), std::stod(found[3]));
}

// Lines of fields, the n-th being the name and the next the value.
Numbers read_parameters(const std::string& text, char separator, int name_field) {
  Numbers out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("#")) continue;
    std::istringstream fields(line);
    std::string field, name;
    for (int i = 0; std::getline(fields, field, separator); ++i) {
      if (i == name_field) name = field;
      if (i == name_field + 1) out[name] = std::stod(field);
    }
  }
  return out;
}

// "name = [1, 2; ...\n 3]" or "name: [...]" or "name = 1": the numbers behind a name.
std::vector<double> numbers_of(const std::string& text, const std::string& name) {
  const auto at = text.find(name);
  if (at == std::string::npos) {
    ADD_FAILURE() << name << " is not in\n" << text;
    return std::vector<double>(9, NAN);
  }
  const auto begin = at + name.size();
  const bool list = text[text.find_first_not_of(" ", begin)] == '[';
  const std::string part = text.substr(begin, text.find(list ? ']' : '\n', begin) - begin);
  std::vector<double> out;
  const std::regex pattern("[-+]?[0-9]+\\.[0-9]+e[-+][0-9]+");
  for (std::sregex_iterator i(part.begin(), part.end(), pattern), end; i != end; ++i) {
    out.push_back(std::stod(i->str()));
  }
  return out;
}

Vector3 vector_of(const std::string& text, const std::string& name) {
  return Eigen::Map<const Vector3>(numbers_of(text, name).data());
}
Matrix3 rows_of(const std::string& text, const std::string& name) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
      numbers_of(text, name).data());
}

TEST(PolarParts, are_a_rotation_and_a_symmetric_matrix_that_keeps_lengths) {
  const Matrix3 M = mag_correction(example(), 0);
  const PolarParts parts = polar_parts(M);
  EXPECT_LT((parts.rotation * parts.symmetric - M).norm(), 1e-12);
  EXPECT_LT((parts.symmetric - parts.symmetric.transpose()).norm(), 1e-12);
  EXPECT_TRUE(parts.rotation.isUnitary(1e-12));
  EXPECT_NEAR(parts.rotation.determinant(), 1.0, 1e-12);
  const Vector3 rpy = roll_pitch_yaw_deg(parts.rotation);
  EXPECT_LT((rotation(rpy[0], rpy[1], rpy[2]) - parts.rotation).norm(), 1e-12);
}

TEST(ExportPx4, does_what_we_do_but_for_the_rotation_it_states) {
  const Calibration c = example(2);
  const Exported out = export_calibration(c, ExportTarget::kPx4);
  const Numbers n = read_parameters(out.text, '\t', 2);
  for (std::size_t m = 0; m < 2; ++m) {
    const std::string name = "CAL_MAG" + std::to_string(m) + "_";
    const Matrix3 S = symmetric(xyz(n, name, "SCALE"), xyz(n, name, "ODIAG"));
    const Matrix3 Q = stated_rotation(out.lost[m]);
    for (const Vector3& raw_uT : samples(60.0)) {
      const Vector3 gauss = S * (raw_uT / 100.0 - xyz(n, name, "OFF"));
      EXPECT_LT((Q * gauss * 100.0 - corrected_mag(c, m, raw_uT)).norm(), kSame);
      EXPECT_NEAR(gauss.norm() * 100.0, corrected_mag(c, m, raw_uT).norm(), kSame);
    }
  }
  for (const Vector3& raw : samples(10.0)) {
    const Vector3 acc = raw - xyz(n, "CAL_ACC0_", "OFF");
    EXPECT_LT((acc - (raw - c.parameters.acc_bias)).norm(), kSame);
    EXPECT_LT((raw - xyz(n, "CAL_GYRO0_", "OFF") - (raw - c.parameters.gyr_bias)).norm(), kSame);
  }
  EXPECT_THAT(out.lost, testing::Contains(HasSubstr("gyroscope's scale errors")));
}

TEST(ExportAutopilots, call_the_loss_of_a_large_rotation_harmful_and_name_the_nearest_axes) {
  Calibration c = example(1, true);
  EXPECT_THAT(export_calibration(c, ExportTarget::kPx4).harmful, IsEmpty());
  const Matrix3 axes = axes_from_text("y,x,-z");
  const Matrix3 tilt = Eigen::AngleAxisd(0.03, Vector3(1.0, 2.0, -1.0).normalized()).matrix();
  c.parameters.mag[0].distortion = c.parameters.mag[0].distortion * tilt * axes;
  for (const ExportTarget target : {ExportTarget::kPx4, ExportTarget::kArdupilot}) {
    EXPECT_THAT(export_calibration(c, target).harmful,
                testing::ElementsAre(
                    testing::AllOf(HasSubstr("--axes mag=y,x,-z"), HasSubstr("1.7 deg are left"))));
    EXPECT_THAT(export_calibration(c, target, {.with_rotation = true}).harmful, IsEmpty());
    EXPECT_THAT(export_calibration(c, target, {.only = {"acc"}}).harmful, IsEmpty());
  }
  for (const ExportTarget target : {ExportTarget::kC, ExportTarget::kRos, ExportTarget::kMatlab}) {
    EXPECT_THAT(export_calibration(c, target).harmful, IsEmpty()) << "its matrix holds a rotation";
  }
}

TEST(ExportAutopilots, do_no_harm_within_the_uncertainty_of_the_calibration) {
  Calibration c = example();  // 0.3 rad
  EXPECT_THAT(export_calibration(c, ExportTarget::kPx4).harmful,
              testing::ElementsAre(testing::Not(HasSubstr("--axes"))));
  c.magnetometers = {MagnetometerRecord{.direction_sigma_deg = 20.0}};
  EXPECT_THAT(export_calibration(c, ExportTarget::kPx4).harmful, IsEmpty());
}

TEST(Export, says_in_which_units_raw_readings_must_come) {
  const auto text = [](ExportTarget target) { return export_calibration(example(), target).text; };
  for (const ExportTarget target : {ExportTarget::kC, ExportTarget::kMatlab}) {
    EXPECT_THAT(text(target), HasSubstr("Raw readings must come in m/s^2, rad/s and uT"));
  }
  EXPECT_THAT(text(ExportTarget::kRos), HasSubstr("uT by 1e-06"));
  EXPECT_THAT(text(ExportTarget::kPx4), HasSubstr("uT by 0.01"));
  EXPECT_THAT(text(ExportTarget::kArdupilot), HasSubstr("uT by 10"));
}

TEST(ExportAutopilots, write_one_sensor_only_where_asked_and_no_scale_that_was_not_estimated) {
  const Calibration c = example();
  for (const ExportTarget target : {ExportTarget::kPx4, ExportTarget::kArdupilot}) {
    const std::string all = export_calibration(c, target).text;
    EXPECT_EQ(all.find("ACC0_XSCALE"), std::string::npos);
    EXPECT_EQ(all.find("ACCSCAL"), std::string::npos);
    EXPECT_NE(all.find(target == ExportTarget::kPx4 ? "CAL_ACC0_XOFF" : "INS_ACCOFFS_X"),
              std::string::npos);
    const std::string mag = export_calibration(c, target, {.only = {"mag"}}).text;
    EXPECT_EQ(mag.find(target == ExportTarget::kPx4 ? "CAL_ACC0_XOFF" : "INS_ACCOFFS_X"),
              std::string::npos);
    EXPECT_NE(mag.find(target == ExportTarget::kPx4 ? "CAL_MAG0_XOFF" : "COMPASS_OFS_X"),
              std::string::npos);
  }
}

TEST(ExportPx4, carries_the_rotation_as_mounting_angles_where_asked) {
  const Calibration c = example();
  const Exported out = export_calibration(c, ExportTarget::kPx4, {.with_rotation = true});
  const Numbers n = read_parameters(out.text, '\t', 2);
  const Matrix3 S = symmetric(xyz(n, "CAL_MAG0_", "SCALE"), xyz(n, "CAL_MAG0_", "ODIAG"));
  const Matrix3 Q = rotation(n.at("CAL_MAG0_ROLL"), n.at("CAL_MAG0_PITCH"), n.at("CAL_MAG0_YAW"));
  for (const Vector3& raw_uT : samples(60.0)) {
    const Vector3 gauss = Q * (S * (raw_uT / 100.0 - xyz(n, "CAL_MAG0_", "OFF")));
    EXPECT_LT((gauss * 100.0 - corrected_mag(c, 0, raw_uT)).norm(), kSame);
  }
  EXPECT_THAT(out.lost, testing::Not(testing::Contains(HasSubstr("rotation of mag"))));
}

TEST(ExportPx4, loses_no_rotation_where_there_is_none) {
  const Calibration c = example(1, true);
  const Exported out = export_calibration(c, ExportTarget::kPx4);
  const Numbers n = read_parameters(out.text, '\t', 2);
  const Matrix3 S = symmetric(xyz(n, "CAL_MAG0_", "SCALE"), xyz(n, "CAL_MAG0_", "ODIAG"));
  for (const Vector3& raw_uT : samples(60.0)) {
    const Vector3 gauss = S * (raw_uT / 100.0 - xyz(n, "CAL_MAG0_", "OFF"));
    EXPECT_LT((gauss * 100.0 - corrected_mag(c, 0, raw_uT)).norm(), kSame);
  }
  EXPECT_THAT(out.lost, testing::Not(testing::Contains(HasSubstr("rotation of mag"))));
}

// mat * (mag + offsets) * scale, after the mounting rotation.
Vector3 ardupilot(const Numbers& n, const std::string& number, const Vector3& raw_uT,
                  const Matrix3& mounting) {
  const Matrix3 S =
      symmetric(xyz(n, "COMPASS_DIA" + number + "_"), xyz(n, "COMPASS_ODI" + number + "_"));
  Vector3 mag = mounting * (raw_uT * 10.0) + xyz(n, "COMPASS_OFS" + number + "_");
  mag *= n.at("COMPASS_SCALE" + number);
  return S * mag / 10.0;
}

TEST(ExportArdupilot, does_what_we_do_but_for_the_rotation_it_states) {
  const Calibration c = example(3);
  const Exported out = export_calibration(c, ExportTarget::kArdupilot);
  const Numbers n = read_parameters(out.text, ',', 0);
  for (std::size_t m = 0; m < 3; ++m) {
    const std::string number = m == 0 ? "" : std::to_string(m + 1);
    const Matrix3 Q = stated_rotation(out.lost[m]);
    for (const Vector3& raw_uT : samples(60.0)) {
      const Vector3 mag = ardupilot(n, number, raw_uT, Matrix3::Identity());
      EXPECT_LT((Q * mag - corrected_mag(c, m, raw_uT)).norm(), kSame);
    }
  }
  for (const Vector3& raw : samples(10.0)) {
    const Vector3 acc = raw - xyz(n, "INS_ACCOFFS_");
    EXPECT_LT((acc - (raw - c.parameters.acc_bias)).norm(), kSame);
    EXPECT_LT((raw - xyz(n, "INS_GYROFFS_") - (raw - c.parameters.gyr_bias)).norm(), kSame);
  }
}

TEST(ExportArdupilot, carries_the_rotation_as_mounting_angles_where_asked) {
  const Calibration c = example(3);
  const Exported out = export_calibration(c, ExportTarget::kArdupilot, {.with_rotation = true});
  const Numbers n = read_parameters(out.text, ',', 0);
  for (std::size_t m = 0; m < 2; ++m) {
    const std::string number = m == 0 ? "" : "2", custom = m == 0 ? "CUST_ROT1_" : "CUST_ROT2_";
    EXPECT_EQ(n.at("COMPASS_ORIENT" + number), 101.0 + double(m));
    const Matrix3 mounting =
        rotation(n.at(custom + "ROLL"), n.at(custom + "PITCH"), n.at(custom + "YAW"));
    for (const Vector3& raw_uT : samples(60.0)) {
      EXPECT_LT((ardupilot(n, number, raw_uT, mounting) - corrected_mag(c, m, raw_uT)).norm(),
                kSame);
    }
  }
  EXPECT_THAT(out.lost, testing::Contains(HasSubstr("after the first 2")));
}

TEST(ExportRos, does_what_we_do_in_tesla) {
  Calibration c = example();
  add_acc_matrix(c);
  const Exported out = export_calibration(c, ExportTarget::kRos);
  const Vector3 bias(numbers_of(out.text, "initial_mag_bias_x:")[0],
                     numbers_of(out.text, "initial_mag_bias_y:")[0],
                     numbers_of(out.text, "initial_mag_bias_z:")[0]);
  for (const Vector3& raw_uT : samples(60.0)) {
    const Vector3 tesla = rows_of(out.text, "initial_mag_scaling_matrix:") * (raw_uT * 1e-6 - bias);
    EXPECT_LT((tesla * 1e6 - corrected_mag(c, 0, raw_uT)).norm(), kSame);
  }
  for (const Vector3& raw : samples(3.0)) {
    const Vector3 rate = rows_of(out.text, "gyroscope_scaling_matrix:") *
                         (raw - vector_of(out.text, "gyroscope_bias:"));
    EXPECT_LT((rate - corrected_gyr(c, raw)).norm(), kSame);
    const Vector3 force = rows_of(out.text, "accelerometer_scaling_matrix:") *
                          (raw - vector_of(out.text, "accelerometer_bias:"));
    EXPECT_LT((force - corrected_acc(c, raw)).norm(), kSame);
  }
  EXPECT_NEAR(numbers_of(out.text, "magnetometer_lag:")[0], 0.011, 1e-12);
  EXPECT_THAT(out.lost, IsEmpty());
}

TEST(ExportMatlab, does_what_we_do_on_rows) {
  Calibration c = example();
  add_acc_matrix(c);
  const Exported out = export_calibration(c, ExportTarget::kMatlab);
  for (const Vector3& raw_uT : samples(60.0)) {
    const Eigen::RowVector3d D = raw_uT.transpose();
    const Eigen::RowVector3d C =
        (D - vector_of(out.text, "\nb = ").transpose()) * rows_of(out.text, "\nA = ");
    EXPECT_LT((C.transpose() - corrected_mag(c, 0, raw_uT)).norm(), kSame);
  }
  for (const Vector3& raw : samples(3.0)) {
    const Eigen::RowVector3d rate =
        (raw - vector_of(out.text, "gyr_bias = ")).transpose() * rows_of(out.text, "gyr_A = ");
    EXPECT_LT((rate.transpose() - corrected_gyr(c, raw)).norm(), kSame);
    const Eigen::RowVector3d force =
        (raw - vector_of(out.text, "acc_bias = ")).transpose() * rows_of(out.text, "acc_A = ");
    EXPECT_LT((force.transpose() - corrected_acc(c, raw)).norm(), kSame);
  }
  EXPECT_NEAR(numbers_of(out.text, "expmfs = ")[0], c.strength_uT, 1e-9);
}

// Compiles a program around the header and lets it correct what it reads.
TEST(ExportC, compiles_as_c99_and_does_what_we_do) {
  Calibration c = example(2);
  add_acc_matrix(c);
  const test::TempFolder folder;
  folder.write("magimu_calibration.h", export_calibration(c, ExportTarget::kC).text);
  folder.write("main.c", R"c(
#include "magimu_calibration.h"
#include <stdio.h>
int main(void) {
  double v[3];
  while (scanf("%lf %lf %lf", v, v + 1, v + 2) == 3) {
    double a[3], g[3], m[3], n[3];
    magimu_correct_acc(v, a);
    magimu_correct_gyr(v, g);
    magimu_correct_mag1(v, m);
    magimu_correct_mag2(v, n);
    printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", a[0], a[1],
           a[2], g[0], g[1], g[2], m[0], m[1], m[2], n[0], n[1], n[2]);
  }
  return 0;
}
)c");
  std::string input;
  for (const Vector3& v : samples(60.0)) {
    std::ostringstream line;
    line.precision(17);
    line << v.transpose() << "\n";
    input += line.str();
  }
  folder.write("in.txt", input);
  const std::string compile = "cd '" + folder.path("") +
                              "' && cc -std=c99 -Wall -Wextra -Wpedantic -Werror -o main main.c "
                              ">log 2>&1 && ./main <in.txt >out.txt";
  ASSERT_EQ(std::system(compile.c_str()), 0) << test::content_of(folder.path("log"));
  std::istringstream output(test::content_of(folder.path("out.txt")));
  int lines = 0;
  for (const Vector3& raw : samples(60.0)) {
    Vector3 acc, gyr, mag[2];
    for (Vector3* v : {&acc, &gyr, &mag[0], &mag[1]}) {
      for (int i = 0; i < 3; ++i) output >> (*v)[i];
    }
    ASSERT_TRUE(output.good());
    EXPECT_LT((acc - corrected_acc(c, raw)).norm(), kSame);
    EXPECT_LT((gyr - corrected_gyr(c, raw)).norm(), kSame);
    EXPECT_LT((mag[0] - corrected_mag(c, 0, raw)).norm(), kSame);
    EXPECT_LT((mag[1] - corrected_mag(c, 1, raw)).norm(), kSame);
    ++lines;
  }
  EXPECT_EQ(lines, 50);
}

TEST(Export, scales_to_the_strength_that_is_asked_for) {
  const Calibration c = example(1, true);
  const Exported out =
      export_calibration(c, ExportTarget::kMatlab, {.strength_uT = 2.0 * c.strength_uT});
  EXPECT_LT((rows_of(out.text, "\nA = ").transpose() - 2.0 * mag_correction(c, 0)).norm(), 1e-9);
}

TEST(Export, keeps_a_file_name_from_ending_its_comment) {
  const Exported out = export_calibration(example(), ExportTarget::kC, {.source = "a*/ int x;\n"});
  const std::string head = out.text.substr(0, out.text.find("#ifndef"));
  EXPECT_EQ(head.find("*/"), head.size() - 3) << head;
}

// PX4 had turned a compass by its mounting and corrected it; what is calibrated is its log.
AppliedCorrection before(Autopilot by, bool mag) {
  AppliedCorrection out;
  out.by = by;
  out.number = 1;
  out.rotation = by == Autopilot::kPx4 ? rotation(180.0, 0.0, 90.0) : rotation(0.0, 0.0, 45.0);
  const Matrix3 S = mag ? symmetric(Vector3(1.05, 0.97, 1.02), Vector3(0.02, -0.01, 0.03))
                        : symmetric(Vector3(1.01, 0.99, 1.02), Vector3::Zero());
  out.matrix = out.rotation * S;
  out.offset = mag ? Vector3(25.0, -8.0, 14.0) : Vector3(0.2, -0.1, 0.3);
  return out;
}

TEST(ExportPx4, of_a_corrected_log_gives_the_parameters_that_correct_raw_readings) {
  const Calibration c = example(1, true);
  ExportOptions options;
  options.applied = {{"mag", before(Autopilot::kPx4, true)},
                     {"acc", before(Autopilot::kPx4, false)}};
  const AppliedCorrection mag = options.applied["mag"], acc = options.applied["acc"];
  const Exported out = export_calibration(c, ExportTarget::kPx4, options);
  const Numbers n = read_parameters(out.text, '\t', 2);
  const Matrix3 S = symmetric(xyz(n, "CAL_MAG1_", "SCALE"), xyz(n, "CAL_MAG1_", "ODIAG"));
  const Matrix3 M = c.strength_uT * c.parameters.mag[0].distortion.inverse();
  for (const Vector3& raw : samples(60.0)) {
    const Vector3 logged = mag.matrix * (raw - mag.offset);
    const Vector3 ours = M * (logged - c.parameters.mag[0].bias);
    const Vector3 theirs = 100.0 * S * (raw / 100.0 - xyz(n, "CAL_MAG1_", "OFF"));
    EXPECT_NEAR(theirs.norm(), ours.norm(), 1e-5);
    // Two symmetric matrices make one that also turns, by little; the mounting is not told anew.
    EXPECT_LT((mag.rotation * theirs - ours).norm(), 0.02 * ours.norm());
  }
  EXPECT_THAT(out.harmful, IsEmpty());
  for (const Vector3& raw : samples(9.0)) {
    const Vector3 ours = acc.matrix * (raw - acc.offset) - c.parameters.acc_bias;
    const Vector3 theirs = acc.matrix * (raw - xyz(n, "CAL_ACC1_", "OFF"));
    EXPECT_LT((ours - theirs).norm(), kSame);
  }
  EXPECT_THAT(out.text, HasSubstr("these are the new ones"));
  EXPECT_TRUE(n.contains("CAL_GYRO0_XOFF"));  // of which nothing was known
}

TEST(ExportArdupilot, of_a_corrected_log_adds_what_was_found_to_the_old_offsets) {
  const Calibration c = example(1, true);
  ExportOptions options;
  options.applied = {{"acc", before(Autopilot::kArdupilot, false)}};
  const AppliedCorrection acc = options.applied["acc"];
  const Exported out = export_calibration(c, ExportTarget::kArdupilot, options);
  const Numbers n = read_parameters(out.text, ',', 0);
  for (const Vector3& raw : samples(9.0)) {
    const Vector3 ours = acc.matrix * (raw - acc.offset) - c.parameters.acc_bias;
    const Vector3 theirs = acc.matrix * (raw - xyz(n, "INS_ACC2OFFS_"));
    EXPECT_LT((ours - theirs).norm(), kSame);
  }
  // Of another autopilot's log it takes nothing.
  const Exported px4 = export_calibration(c, ExportTarget::kPx4, options);
  EXPECT_TRUE(read_parameters(px4.text, '\t', 2).contains("CAL_ACC0_XOFF"));
}

TEST(AppliedCorrections, are_the_same_after_a_file) {
  Recording r;
  r.mag_names = {"mag"};
  set_applied(r.file_units, "mag", before(Autopilot::kPx4, true));
  turn_applied(r.file_units, "mag", rotation(0.0, 0.0, 90.0));
  nlohmann::ordered_json file;
  add_applied(file, {&r});
  const AppliedCorrections again =
      applied_from_json(nlohmann::ordered_json::parse(file.dump()), "cal.json");
  ASSERT_EQ(again.size(), 1u);
  const AppliedCorrection& is = again.at("mag");
  EXPECT_EQ(is.number, 1);
  EXPECT_EQ(is.offset, before(Autopilot::kPx4, true).offset);
  EXPECT_LT((is.matrix - rotation(0.0, 0.0, 90.0) * before(Autopilot::kPx4, true).matrix).norm(),
            1e-12);
  const Recording other;
  EXPECT_TRUE(applied_to_all({&r, &other}).empty());
  file["applied"]["mag"]["matrix"] = "x";
  EXPECT_THROW(applied_from_json(file, "cal.json"), InputError);
}

}  // namespace
}  // namespace magimu
