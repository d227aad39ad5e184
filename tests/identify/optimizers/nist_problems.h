#pragma once

/// @file
/// Nonlinear regression problems of the NIST Statistical Reference Datasets (public domain,
/// https://www.itl.nist.gov/div898/strd/nls/nls_main.shtml): data, starts, and the certified
/// parameters and residual sums of squares, as printed there to 11 digits. Both starts, but for
/// MGH10 and BoxBOD, whose first start lies behind a plateau that no descent crosses.

#include <ceres/jet.h>

#include <cmath>
#include <ostream>
#include <string>
#include <vector>

namespace lipoid::test {

using NistJet = ceres::Jet<double, 7>;

struct NistProblem {
  std::string name;
  NistJet (*model)(const std::vector<NistJet>& b, double x);
  std::vector<std::vector<double>> starts;
  std::vector<double> certified;
  double certified_sum_of_squares = 0.0;
  std::vector<double> x;
  std::vector<double> y;
};

inline void PrintTo(const NistProblem& problem, std::ostream* out) { *out << problem.name; }

inline std::vector<NistProblem> NistProblems() {
  using B = std::vector<NistJet>;
  std::vector<NistProblem> all;
  all.push_back({.name = "Misra1a",
                 .model = [](const B& b, double x) { return b[0] * (1.0 - exp(-b[1] * x)); },
                 .starts = {{500.0, 0.0001}, {250.0, 0.0005}},
                 .certified = {2.3894212918E+02, 5.5015643181E-04},
                 .certified_sum_of_squares = 1.2455138894E-01,
                 .x = {77.6,
                       114.9,
                       141.1,
                       190.8,
                       239.9,
                       289.0,
                       332.8,
                       378.4,
                       434.8,
                       477.3,
                       536.8,
                       593.1,
                       689.1,
                       760.0},
                 .y = {10.07,
                       14.73,
                       17.94,
                       23.93,
                       29.61,
                       35.18,
                       40.02,
                       44.82,
                       50.76,
                       55.05,
                       61.01,
                       66.40,
                       75.47,
                       81.78}});
  all.push_back(
      {.name = "Thurber",
       .model =
           [](const B& b, double x) {
             return (b[0] + x * (b[1] + x * (b[2] + x * b[3]))) /
                    (1.0 + x * (b[4] + x * (b[5] + x * b[6])));
           },
       .starts = {{1000.0, 1000.0, 400.0, 40.0, 0.7, 0.3, 0.03},
                  {1300.0, 1500.0, 500.0, 75.0, 1.0, 0.4, 0.05}},
       .certified = {1.2881396800E+03,
                     1.4910792535E+03,
                     5.8323836877E+02,
                     7.5416644291E+01,
                     9.6629502864E-01,
                     3.9797285797E-01,
                     4.9727297349E-02},
       .certified_sum_of_squares = 5.6427082397E+03,
       .x = {-3.067, -2.981, -2.921, -2.912, -2.840, -2.797, -2.702, -2.699, -2.633, -2.481,
             -2.363, -2.322, -1.501, -1.460, -1.274, -1.212, -1.100, -1.046, -0.915, -0.714,
             -0.566, -0.545, -0.400, -0.309, -0.109, -0.103, 0.010,  0.119,  0.377,  0.790,
             0.963,  1.006,  1.115,  1.572,  1.841,  2.047,  2.200},
       .y = {80.574,   84.248,   87.264,   87.195,   89.076,   89.608,   89.868,   90.101,
             92.405,   95.854,   100.696,  101.060,  401.672,  390.724,  567.534,  635.316,
             733.054,  759.087,  894.206,  990.785,  1090.109, 1080.914, 1122.643, 1178.351,
             1260.531, 1273.514, 1288.339, 1327.543, 1353.863, 1414.509, 1425.208, 1421.384,
             1442.962, 1464.350, 1468.705, 1447.894, 1457.628}});
  all.push_back(
      {.name = "MGH09",
       .model = [](const B& b,
                   double x) { return b[0] * (x * x + x * b[1]) / (x * x + x * b[2] + b[3]); },
       .starts = {{25.0, 39.0, 41.5, 39.0}, {0.25, 0.39, 0.415, 0.39}},
       .certified = {1.9280693458E-01, 1.9128232873E-01, 1.2305650693E-01, 1.3606233068E-01},
       .certified_sum_of_squares = 3.0750560385E-04,
       .x = {4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625},
       .y = {
           0.1957, 0.1947, 0.1735, 0.16, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246}});
  all.push_back({.name = "MGH10",
                 .model = [](const B& b, double x) { return b[0] * exp(b[1] / (x + b[2])); },
                 .starts = {{0.02, 4000.0, 250.0}},
                 .certified = {5.6096364710E-03, 6.1813463463E+03, 3.4522363462E+02},
                 .certified_sum_of_squares = 8.7945855171E+01,
                 .x = {50, 55, 60, 65, 70, 75, 80, 85, 90, 95, 100, 105, 110, 115, 120, 125},
                 .y = {34780,
                       28610,
                       23650,
                       19630,
                       16370,
                       13720,
                       11540,
                       9744,
                       8261,
                       7030,
                       6005,
                       5147,
                       4427,
                       3820,
                       3307,
                       2872}});
  all.push_back(
      {.name = "Rat43",
       .model = [](const B& b,
                   double x) { return b[0] / pow(1.0 + exp(b[1] - b[2] * x), 1.0 / b[3]); },
       .starts = {{100.0, 10.0, 1.0, 1.0}, {700.0, 5.0, 0.75, 1.3}},
       .certified = {6.9964151270E+02, 5.2771253025E+00, 7.5962938329E-01, 1.2792483859E+00},
       .certified_sum_of_squares = 8.7864049080E+03,
       .x = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15},
       .y = {16.08,
             33.83,
             65.80,
             97.20,
             191.55,
             326.20,
             386.87,
             520.53,
             590.03,
             651.92,
             724.93,
             699.56,
             689.96,
             637.56,
             717.41}});
  all.push_back(
      {.name = "Eckerle4",
       .model =
           [](const B& b, double x) {
             const NistJet z = (x - b[2]) / b[1];
             return b[0] / b[1] * exp(-0.5 * z * z);
           },
       .starts = {{1.0, 10.0, 500.0}, {1.5, 5.0, 450.0}},
       .certified = {1.5543827178E+00, 4.0888321754E+00, 4.5154121844E+02},
       .certified_sum_of_squares = 1.4635887487E-03,
       .x = {400.0, 405.0, 410.0, 415.0, 420.0, 425.0, 430.0, 435.0, 436.5, 438.0, 439.5, 441.0,
             442.5, 444.0, 445.5, 447.0, 448.5, 450.0, 451.5, 453.0, 454.5, 456.0, 457.5, 459.0,
             460.5, 462.0, 463.5, 465.0, 470.0, 475.0, 480.0, 485.0, 490.0, 495.0, 500.0},
       .y = {0.0001575, 0.0001699, 0.0002350, 0.0003102, 0.0004917, 0.0008710, 0.0017418,
             0.0046400, 0.0065895, 0.0097302, 0.0149002, 0.0237310, 0.0401683, 0.0712559,
             0.1264458, 0.2073413, 0.2902366, 0.3445623, 0.3698049, 0.3668534, 0.3106727,
             0.2078154, 0.1164354, 0.0616764, 0.0337200, 0.0194023, 0.0117831, 0.0074357,
             0.0022732, 0.0008800, 0.0004579, 0.0002345, 0.0001586, 0.0001143, 0.0000710}});
  all.push_back({.name = "BoxBOD",
                 .model = [](const B& b, double x) { return b[0] * (1.0 - exp(-b[1] * x)); },
                 .starts = {{100.0, 0.75}},
                 .certified = {2.1380940889E+02, 5.4723748542E-01},
                 .certified_sum_of_squares = 1.1680088766E+03,
                 .x = {1, 2, 3, 5, 7, 10},
                 .y = {109, 149, 149, 191, 213, 224}});
  return all;
}

}  // namespace lipoid::test
