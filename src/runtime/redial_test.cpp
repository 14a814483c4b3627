#include "runtime/redial.h"

#include <gtest/gtest.h>

namespace ctn::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(Redial, IsNotDueUntilAServerIsLost) {
  Redial redial;
  EXPECT_EQ(redial.due(), kNever);
  redial.at_once(TimePoint{seconds{1}});
  EXPECT_EQ(redial.due(), TimePoint{seconds{1}});
  redial.not_now();
  EXPECT_EQ(redial.due(), kNever);
}

TEST(Redial, ComesSoonAgainWhereNoServerAnswers) {
  Redial redial;
  TimePoint now{seconds{1}};
  for (int tries = 0; tries < 100; ++tries) {
    redial.unanswered(now);
    EXPECT_EQ(redial.due(), now + Redial::kUsual);
    now = redial.due();
  }
}

TEST(Redial, ComesMoreAndMoreSeldomWhereItIsRefused) {
  Redial redial;
  TimePoint now{seconds{1}};
  Nanos before = Redial::kUsual / 2;
  for (int tries = 0; tries < 12; ++tries) {
    redial.refused(now, false);
    EXPECT_EQ(redial.due() - now, std::min(2 * before, Redial::kMaxDelay)) << tries;
    before = redial.due() - now;
    now = redial.due();
  }
  EXPECT_EQ(before, Redial::kMaxDelay);
}

// The server that went on had not read yet that the program had hung up, and refused it: its next try came after up to
// five seconds.
TEST(Redial, AsksTheServerThatItWasWithSoonAgain) {
  Redial redial;
  TimePoint now{seconds{1}};
  redial.refused(now, true);
  EXPECT_EQ(redial.due(), now + Redial::kMinDelay);
}

// An answer that did not come counted as a refusal.
TEST(Redial, ForgetsRefusalsOnceNoServerAnswers) {
  Redial redial;
  TimePoint now{seconds{1}};
  for (int tries = 0; tries < 12; ++tries) redial.refused(now, false);
  redial.unanswered(now);
  EXPECT_EQ(redial.due(), now + Redial::kUsual);
  redial.refused(now, false);
  EXPECT_EQ(redial.due(), now + Redial::kUsual);
}

}  // namespace
}  // namespace ctn::runtime
