// SPDX-License-Identifier: BSD-3-Clause
// Reads the files of the NIST Statistical Reference Datasets, nonlinear regression: data, two
// starting points, and what NIST certifies of the answer, to 11 digits.
#pragma once

#include <array>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace magimu::nist {

struct Observation {
  double y = 0.0;
  std::array<double, 2> x = {};  // the second is used by one problem only
};

struct Parameter {
  std::array<double, 2> start = {};
  double certified = 0.0, deviation = 0.0;
};

struct File {
  std::string name;
  std::vector<Parameter> parameters;
  double residual_sum_of_squares = 0.0;
  double residual_deviation = 0.0;  // sqrt(sum of squares / (observations - parameters))
  std::vector<Observation> data;

  // Not the number the file gives: Rat43's is misprinted, its deviation is not.
  int degrees_of_freedom() const { return int(data.size() - parameters.size()); }
};

// Throws std::runtime_error, with the file's name, where it is not what its format promises.
inline File read_file(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error(path + " cannot be opened");
  const auto fail = [&](const std::string& what) {
    throw std::runtime_error(path + " is no NIST regression problem: " + what);
  };
  const auto number_after = [&](const std::string& line) {
    std::istringstream words(line.substr(line.find(':') + 1));
    double number = 0.0;
    if (!(words >> number)) fail("no number in '" + line + "'");
    return number;
  };
  File file;
  int data_headings = 0;  // the first introduces the description, the second the table
  std::size_t observations = 0;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    if (line.starts_with("Dataset Name:")) {
      words.ignore(13);
      words >> file.name;
    } else if (line.starts_with("Residual Sum of Squares:")) {
      file.residual_sum_of_squares = number_after(line);
    } else if (line.starts_with("Residual Standard Deviation:")) {
      file.residual_deviation = number_after(line);
    } else if (line.starts_with("Number of Observations:")) {
      observations = std::size_t(number_after(line));
    } else if (line.starts_with("Data:")) {
      ++data_headings;
    } else if (data_headings == 2) {
      Observation o;
      if (words >> o.y >> o.x[0]) {
        words >> o.x[1];
        file.data.push_back(o);
      }
    } else {
      Parameter p;
      std::string name, equals;
      words >> name >> equals >> p.start[0] >> p.start[1] >> p.certified >> p.deviation;
      if (words && name == "b" + std::to_string(file.parameters.size() + 1) && equals == "=") {
        file.parameters.push_back(p);
      }
    }
  }
  if (file.parameters.empty()) fail("no parameters");
  if (observations == 0 || file.data.size() != observations) fail("observations are missing");
  if (file.degrees_of_freedom() <= 0) fail("fewer observations than parameters");
  return file;
}

}  // namespace magimu::nist
