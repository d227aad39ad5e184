#include "model/battery/cell_model.h"

#include <boost/math/special_functions/trigamma.hpp>

namespace lipoid {

double TailSum(int terms) { return boost::math::trigamma(terms + 1.0); }

}  // namespace lipoid
