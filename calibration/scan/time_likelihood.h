// SPDX-License-Identifier: BSD-3-Clause
// How likely the times of one end of a change are, by grids that get finer: each grid counts where
// no finer one has looked. (A fine grid about the best time alone does not see another one, some
// tenths of a second away, that is nearly as likely.)
#pragma once

#include <cstddef>
#include <vector>

namespace magimu {

// Times on a grid, in any order, and the nats by which each is better than the one from which they
// were looked for.
struct LikelyTimes {
  std::vector<double> t = {}, gain = {};
  double grid_s = 0.0;
  std::size_t best() const;
  double best_t() const { return t[best()]; }
};

class TimeLikelihood {
 public:
  // What a grid says; the last one of the same reach is forgotten.
  void take(LikelyTimes finest);
  // Grids from now on look so far to both sides of the best time only.
  void narrow(double within_s);

  // How far the others lie about the best time: the root of their mean square.
  double sigma_s() const;
  // How long a time all of the likelihood would last at its largest; 0 where nothing was taken.
  double width_s() const;

 private:
  // How much of it lies about the best time.
  struct Share {
    double mass = 0.0;                 // s, at the likelihood of the best time
    double first = 0.0, second = 0.0;  // moments about the best time, s^2, s^3
    void add(double off_s, double weight_s);
  };
  double weight_s(std::size_t i) const;
  Share all() const;

  double t_ = 0.0;
  LikelyTimes finest_ = {};
  Share beyond_ = {};  // the reach of finest_
};

}  // namespace magimu
