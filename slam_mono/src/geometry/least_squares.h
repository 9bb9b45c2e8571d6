#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>

namespace rubble::slam_mono {

/// Gauss-Newton's equations H delta = -g of a weighted sum of squares.
template <int N>
struct NormalEquations {
  Eigen::Matrix<double, N, N> H = Eigen::Matrix<double, N, N>::Zero();
  Eigen::Matrix<double, N, 1> g = Eigen::Matrix<double, N, 1>::Zero();
  double cost = 0.0;

  template <int M>
  void add(const Eigen::Matrix<double, M, N>& J, const Eigen::Matrix<double, M, 1>& error, double weight) {
    // Columns along N: Eigen makes vector instructions of them.
    const Eigen::Matrix<double, N, M> columns = J.transpose();
    const Eigen::Matrix<double, N, M> weighted = weight * columns;
    H.noalias() += weighted * columns.transpose();
    g.noalias() += weighted * error;
  }
};

/// Huber's kernel on a squared error: linear growth from the squared bound on.
inline double huberCost(double squared, double bound) {
  return squared <= bound ? squared : 2.0 * std::sqrt(bound * squared) - bound;
}
inline double huberWeight(double squared, double bound) {
  return squared <= bound ? 1.0 : std::sqrt(bound / squared);
}

/// Levenberg-Marquardt with Marquardt's scaling of the damping (Madsen, Nielsen & Tingleff 2004).
/// linearize(state) gives the NormalEquations<N> there, moved(state, delta) the state a step on. Ends with a
/// step that is worth less than 1e-4 of the cost: with normalised errors a hundredth of the standard
/// deviation.
template <int N, typename State, typename Linearize, typename Moved>
void levenbergMarquardt(State& state, int iterations, Linearize&& linearize, Moved&& moved) {
  constexpr double kConvergedGain = 1e-4;
  constexpr double kMaxDamping = 1e6;
  double damping = 1e-5;
  NormalEquations<N> now = linearize(state);
  for (int i = 0; i < iterations && damping < kMaxDamping; ++i) {
    Eigen::Matrix<double, N, N> H = now.H;
    H.diagonal() *= 1.0 + damping;
    const Eigen::Matrix<double, N, 1> delta = -H.ldlt().solve(now.g);
    if (!delta.allFinite()) {
      return;
    }
    const State next_state = moved(state, delta);
    if (-now.g.dot(delta) < kConvergedGain) {
      state = next_state;
      return;
    }
    const NormalEquations<N> next = linearize(next_state);
    if (next.cost < now.cost) {
      state = next_state;
      now = next;
      damping *= 0.1;
    } else {
      damping *= 10.0;
    }
  }
}

}  // namespace rubble::slam_mono
