#include "model/statistics/student.h"

#include <boost/math/distributions/students_t.hpp>

namespace lipoid {

double StudentQuantile(double degrees_of_freedom, double probability) {
  return boost::math::quantile(boost::math::students_t(degrees_of_freedom), probability);
}

double Reach95(double degrees_of_freedom) { return StudentQuantile(degrees_of_freedom, 0.975); }

}  // namespace lipoid
