#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "identify/trust/trust.h"

namespace lipoid {
namespace {

QuantityTrust Quantity(const std::string& name,
                       double estimate,
                       Verdict verdict,
                       const std::vector<std::string>& with = {}) {
  QuantityTrust q;
  q.name = name;
  q.estimate = estimate;
  q.low = 0.5 * estimate;
  q.verdict = verdict;
  q.with = with;
  q.relative_standard_error = verdict == Verdict::kIdentified ? 0.01 : 0.5;
  return q;
}

std::string SentenceOf(const std::vector<QuantityTrust>& quantities, double sampling_s = 1.0) {
  TrustReport report;
  report.quantities = quantities;
  report.sampling_s = sampling_s;
  return TrustSentence(report);
}

constexpr auto kGood = Verdict::kIdentified;
constexpr auto kTogether = Verdict::kOnlyInCombination;

TEST(TrustSentence, AsksForLongerRestsWhereABranchStandsForTheDiffusion) {
  EXPECT_EQ(SentenceOf({Quantity("beta", 0.2, kTogether, {"r_1"}),
                        Quantity("r_s", 0.1, kGood),
                        Quantity("r_1", 0.05, kTogether, {"beta"}),
                        Quantity("tau_1", 30.0, kGood)}),
            "beta and r_1 cannot be told apart by these logs; longer rests would");
}

TEST(TrustSentence, AsksForFasterSamplingWhereABranchHidesInTheEdge) {
  EXPECT_EQ(SentenceOf({Quantity("r_s", 0.1, kTogether, {"r_1"}),
                        Quantity("r_1", 0.05, kTogether, {"r_s"}),
                        Quantity("tau_1", 2.0, kGood)}),
            "r_s and r_1 cannot be told apart by these logs; faster sampling at the edges of the "
            "pulses would");
  EXPECT_EQ(
      SentenceOf({Quantity("r_s", 0.1, kTogether, {"r_1"}),
                  Quantity("r_1", 0.05, kTogether, {"r_s"}),
                  Quantity("tau_1", 0.2, Verdict::kWeak)}),
      "branch 1 (tau_1 = 0.2 s) is faster than the sampling (1 s), so that r_1 cannot be told "
      "from r_s; faster sampling at the edges of the pulses would tell them apart");
}

TEST(TrustSentence, SaysWhatTheStructureLeavesOpen) {
  auto r = Quantity("r_1", 0.05, Verdict::kWeak);
  r.open_by_model = true;
  r.relative_standard_error = 0.1;
  r.standard_error = 0.005;
  r.model_standard_error = 0.004;
  EXPECT_EQ(SentenceOf({Quantity("beta", 0.2, kGood), r, Quantity("tau_1", 30.0, kGood)}),
            "the noise of these logs leaves r_1 open to 6 %, other structures of the cell that "
            "predict them nearly as well, or what was held, to 10 % (one standard error); give the "
            "structure if you know it, or add logs at other currents and with other rests");
}

TEST(TrustSentence, SaysThatABranchWasNotFound) {
  auto tau = Quantity("tau_1", 2.4e-4, Verdict::kWeak);
  tau.insensitive = true;
  tau.relative_standard_error = std::numeric_limits<double>::infinity();
  EXPECT_EQ(
      SentenceOf({Quantity("beta", 0.2, kGood), Quantity("r_1", 0.0, Verdict::kAtBound), tau}),
      "branch 1 was not found: r_1 cannot be told from zero, and its time constant means nothing; "
      "a model "
      "with one branch less says the same");
}

TEST(TrustSentence, TakesABranchThatMayBeZeroAsNotFound) {
  auto r = Quantity("r_1", 9e-6, Verdict::kWeak);
  r.low = 0.0;
  const auto text =
      SentenceOf({Quantity("beta", 0.2, kGood), r, Quantity("tau_1", 300.0, Verdict::kWeak)});
  EXPECT_EQ(text.find("branch 1 was not found"), 0U) << text;
  // That r_s is known only with r_1 is the same news.
  const auto with_r_s = SentenceOf({Quantity("beta", 0.2, kGood),
                                    Quantity("r_s", 0.1, kTogether, {"r_1"}),
                                    r,
                                    Quantity("tau_1", 300.0, Verdict::kWeak)});
  EXPECT_EQ(with_r_s, text);
}

TEST(TrustSentence, SaysAtMostTwoThings) {
  const auto text = SentenceOf({Quantity("beta", 1.0, Verdict::kAtBound),
                                Quantity("r_1", 0.0, Verdict::kAtBound),
                                Quantity("tau_2", 30.0, Verdict::kWeak),
                                Quantity("r_s", 0.1, Verdict::kWeak)});
  EXPECT_NE(text.find("branch 1 was not found"), std::string::npos) << text;
  EXPECT_NE(text.find("; also, beta is at a limit of its range, which suggests an effect that the "
                      "model lacks"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("beyond"), std::string::npos) << "that is a caveat: " << text;
  EXPECT_EQ(text.find("r_s"), std::string::npos) << text;
}

TEST(TrustSentence, SaysWhatIsWeakAndWhatWouldHelp) {
  EXPECT_EQ(SentenceOf({Quantity("alpha", 1000.0, Verdict::kWeak)}),
            "alpha is weak (standard error 50 %); discharges at currents further apart, or more of "
            "them, would help");
  EXPECT_EQ(
      SentenceOf({Quantity("beta", 0.1, kGood)}),
      "every parameter is identified; the least certain is beta, to 1 % (one standard error)");
  EXPECT_EQ(SentenceOf({}), "every parameter was given");
}

TEST(TrustSentence, CountsWhereManyAreWeak) {
  auto i_0 = Quantity("i_0", 1.5, Verdict::kWeak);
  i_0.relative_standard_error = 6.8;
  EXPECT_EQ(SentenceOf({Quantity("alpha", 1000.0, kGood),
                        Quantity("beta", 0.7, Verdict::kWeak),
                        Quantity("r_s", 0.1, Verdict::kWeak),
                        i_0}),
            "3 of 4 quantities are weak, i_0 the most (standard error 6.8 times its value); longer "
            "rests, or a higher rate, would help");
  i_0.relative_standard_error = 1e4;
  EXPECT_EQ(SentenceOf({Quantity("alpha", 1000.0, kGood), i_0}),
            "i_0 is weak (standard error over a hundred times its value); longer rests, or a "
            "higher rate, would help");
}

}  // namespace
}  // namespace lipoid
