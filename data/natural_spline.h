#pragma once

#include <Eigen/Core>

namespace sinew {

/// Interpolating natural spline of degree 2m − 1, m = half_order, through every column of y: the
/// curve of least ∫(f^(m))² through the points; its derivatives m … 2m − 2 vanish at both ends
/// (Schoenberg 1964). m = 2 is the natural cubic, m = 3 the quintic that OpenSim differentiates
/// coordinates with (GCVSPL, Woltring 1986, without smoothing).
///
/// x: n strictly increasing abscissae; y: n × columns. Returns 2m·(n − 1) × columns: row 2m·i + k
/// is the coefficient of (x − x_i)^k on the interval [x_i, x_{i+1}]. O(n·m²) a column. Throws
/// std::invalid_argument if m is not 1…4, n < 2m, sizes differ, a value is not finite, or x does
/// not increase strictly.
Eigen::MatrixXd natural_spline_coefficients(const Eigen::VectorXd& x, const Eigen::MatrixXd& y,
                                            int half_order);

}  // namespace sinew
