// SPDX-License-Identifier: BSD-3-Clause
// Example 2: a factor of one's own. A beacon on a lever arm (an antenna on a mast, say) is carried
// around by a turning body; stations at known places measure their distance to it. Unknown are the
// body's place and the lever; the headings are known. One distance in six bounced off a wall.
//
// The factor states its residual, once, as a template over the scalar: its Jacobians come from
// automatic differentiation. A robust loss then keeps the wrong distances from mattering.
#include <cstdio>
#include <random>

#include <magimu/graph/factor_graph.h>
#include <magimu/solvers/levenberg_marquardt.h>

using namespace magimu;

// r = |p + R(heading) lever - station| - distance: one residual, on two unknown plane vectors.
class RangeFactor : public Factor<1, Vector2, Vector2> {
 public:
  RangeFactor(Key position, Key lever, double heading_rad, const Vector2& station, double distance,
              const Noise<1>& noise)
      : Factor({position, lever}, noise),
        heading_rad_(heading_rad),
        station_(station),
        distance_(distance) {}

  template <class T>
  Vec<T, 1> residual(const Vec<T, 2>& p, const Vec<T, 2>& lever) const {
    using std::sqrt;  // finds the sqrt of double here, that of automatic differentiation by itself
    const T c(std::cos(heading_rad_)), s(std::sin(heading_rad_));
    const Vec<T, 2> turned(c * lever[0] - s * lever[1], s * lever[0] + c * lever[1]);
    const Vec<T, 2> d = p + turned - station_.cast<T>();
    return Vec<T, 1>(sqrt(d.dot(d)) - distance_);
  }

 private:
  double heading_rad_;
  Vector2 station_;
  double distance_;
};

constexpr Key kPosition{'p', 0}, kLever{'l', 0};
const Vector2 kTruePosition(3.0, 4.0), kTrueLever(0.8, -0.3);
constexpr double kSigma = 0.02;  // m

double lever_error(Loss loss) {
  std::mt19937 engine(2);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> detour(0.5, 5.0);  // m: a bounce is always longer
  const Noise<1> noise = Noise<1>::isotropic(kSigma).with_loss(loss);
  FactorGraph graph;
  int count = 0;
  for (double heading = 0.0; heading < 6.2; heading += 0.3) {
    for (const Vector2& station : {Vector2(0, 0), Vector2(10, 0), Vector2(0, 10)}) {
      const Vector2 beacon = kTruePosition + Eigen::Rotation2Dd(heading) * kTrueLever;
      double distance = (beacon - station).norm() + kSigma * normal(engine);
      if (++count % 6 == 0) distance += detour(engine);
      graph.add(RangeFactor(kPosition, kLever, heading, station, distance, noise));
    }
  }
  Values start;
  start.insert(kPosition, Vector2(5.0, 5.0));
  start.insert(kLever, Vector2(0.0, 0.0));
  const Result result = LevenbergMarquardt(graph).optimize(start);
  const Vector2 lever = result.values.at<Vector2>(kLever);
  std::printf("lever (%.3f, %.3f) m, after %d steps. %s\n", lever[0], lever[1], result.iterations,
              result.message.c_str());
  return result.converged() ? (lever - kTrueLever).norm() : 1e9;
}

int main() {
  std::printf("truth (%.3f, %.3f) m\n", kTrueLever[0], kTrueLever[1]);
  const double plain = lever_error({}), robust = lever_error(Loss::cauchy());
  std::printf("error without a loss %.3f m, with Cauchy's %.3f m\n", plain, robust);
  return robust < 0.02 && robust < 0.2 * plain ? 0 : 1;
}
