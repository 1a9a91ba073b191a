// SPDX-License-Identifier: BSD-3-Clause
// Reads the rotations of a 3D pose graph in g2o's text format:
//   VERTEX_SE3:QUAT id x y z qx qy qz qw
//   EDGE_SE3:QUAT i j x y z qx qy qz qw, and the upper triangle of the 6x6 information matrix
// Of the information the rotation's 3x3 block is taken, as that of a rotation vector.
#pragma once

#include <Eigen/LU>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "graph/rot3.h"

namespace magimu::g2o {

struct Edge {
  int i = 0, j = 0;
  Rot3 iRj;            // from frame j to frame i
  Matrix3 covariance;  // of the small rotation in frame j, rad^2
};

struct File {
  std::vector<Rot3> rotations;  // vertex k's is number k
  std::vector<Edge> edges;
};

// Throws std::runtime_error, with file and line, where it is not what the format promises.
inline File read_file(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error(path + " cannot be opened");
  File file;
  int number = 0;
  const auto require = [&](bool holds, const std::string& what) {
    if (!holds) throw std::runtime_error(path + ":" + std::to_string(number) + ": " + what);
  };
  for (std::string line, tag; std::getline(in, line);) {
    ++number;
    std::istringstream words(line);
    const auto rotation = [&] {  // of a position and a quaternion
      double unused = 0.0;
      words >> unused >> unused >> unused;
      Vector4 wxyz = Vector4::Zero();
      words >> wxyz[1] >> wxyz[2] >> wxyz[3] >> wxyz[0];
      require(bool(words) && wxyz.norm() > 0.5, "a position and a quaternion are expected");
      return Rot3::from_quaternion(wxyz);
    };
    tag.clear();
    words >> tag;
    if (tag == "VERTEX_SE3:QUAT") {
      int id = -1;
      words >> id;
      require(id == int(file.rotations.size()), "vertices must be numbered 0, 1, 2, ...");
      file.rotations.push_back(rotation());
    } else if (tag == "EDGE_SE3:QUAT") {
      Edge edge;
      words >> edge.i >> edge.j;
      edge.iRj = rotation();
      Eigen::Matrix<double, 6, 6> information;
      for (int r = 0; r < 6; ++r) {
        for (int c = r; c < 6; ++c) {
          words >> information(r, c);
          information(c, r) = information(r, c);
        }
      }
      require(bool(words), "21 numbers of the information matrix are expected");
      edge.covariance = information.bottomRightCorner<3, 3>().inverse();
      file.edges.push_back(edge);
    }
  }
  const auto known = [&](int id) { return id >= 0 && id < int(file.rotations.size()); };
  for (const Edge& e : file.edges) {
    require(known(e.i) && known(e.j), "an edge joins a vertex that is not there");
  }
  require(!file.rotations.empty(), "no vertices");
  return file;
}

}  // namespace magimu::g2o
