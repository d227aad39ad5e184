#include "model/statistics/quantiles.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace lipoid {

double StudentQuantile(double degrees_of_freedom, double probability) {
  return boost::math::quantile(boost::math::students_t(degrees_of_freedom), probability);
}

double Reach95(double degrees_of_freedom) { return StudentQuantile(degrees_of_freedom, 0.975); }

double ChiSquaredPassed(double degrees_of_freedom, double probability) {
  const boost::math::chi_squared distribution(degrees_of_freedom);
  return boost::math::quantile(boost::math::complement(distribution, probability));
}

double FisherPassed(double degrees_of_freedom, double within, double probability) {
  const boost::math::fisher_f distribution(degrees_of_freedom, within);
  return boost::math::quantile(boost::math::complement(distribution, probability));
}

}  // namespace lipoid
