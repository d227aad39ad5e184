#include "identify/studies/effective_rows.h"

#include <algorithm>
#include <complex>
#include <cstddef>
#include <unsupported/Eigen/FFT>

namespace lipoid {
namespace {

constexpr std::size_t kMostBlocks = std::size_t{1} << 20;

double Mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

// Means of so many neighbours; what is left over at the end is dropped.
std::vector<double> BlockMeans(const std::vector<double>& values, std::size_t length) {
  std::vector<double> means(values.size() / length);
  for (std::size_t b = 0; b < means.size(); ++b) {
    for (std::size_t k = 0; k < length; ++k) means[b] += values[b * length + k];
    means[b] /= static_cast<double>(length);
  }
  return means;
}

// sum_k x(k) x(k + lag) for every lag, x without its mean. Padded to twice the length, so that the
// ends do not meet, and to a power of two.
std::vector<double> Autocovariance(std::vector<double> x) {
  const std::size_t n = x.size();
  const double mean = Mean(x);
  for (double& value : x) value -= mean;
  std::size_t padded = 2;
  while (padded < 2 * n) padded *= 2;
  x.resize(padded, 0.0);
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> spectrum;
  fft.fwd(spectrum, x);
  for (auto& value : spectrum) value = std::norm(value);
  fft.inv(x, spectrum);
  x.resize(n);
  return x;
}

}  // namespace

double EffectiveRows(const std::vector<std::vector<double>>& residuals) {
  std::size_t rows = 0;
  for (const auto& log : residuals) rows += log.size();
  const std::size_t block = (rows + kMostBlocks - 1) / kMostBlocks;
  double squares = 0.0;            // about each log's own mean
  std::vector<double> covariance;  // of the blocks, all logs together
  for (const auto& log : residuals) {
    if (log.size() < std::max<std::size_t>(block, 1)) continue;
    const double mean = Mean(log);
    for (const double v : log) squares += (v - mean) * (v - mean);
    const auto one = Autocovariance(BlockMeans(log, block));
    covariance.resize(std::max(covariance.size(), one.size()), 0.0);
    for (std::size_t k = 0; k < one.size(); ++k) covariance[k] += one[k];
  }
  const auto all = static_cast<double>(rows);
  if (!(squares > 0.0)) return std::max(all, 1.0);
  double sum = -covariance[0];
  for (std::size_t m = 0; m + 1 < covariance.size(); m += 2) {
    const double pair = covariance[m] + covariance[m + 1];
    if (!(pair > 0.0)) break;
    sum += 2.0 * pair;
  }
  // The variance of the mean against that of as many independent rows; a block is the mean of
  // `block` rows, hence its square.
  const double correlation_time = static_cast<double>(block * block) * sum / squares;
  return std::clamp(all / correlation_time, 1.0, std::max(all, 1.0));
}

}  // namespace lipoid
