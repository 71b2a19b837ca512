#include "server/base/token_bucket.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(TokenBucket, GivesItsBurstAtOnceAndThenItsRate) {
  const auto at = [](double seconds) {
    return std::chrono::duration_cast<TokenBucket::Time>(std::chrono::duration<double>(seconds));
  };
  TokenBucket bucket(10.0, 20.0, at(0.0));
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(bucket.take(1.0, at(0.0))) << i;
  EXPECT_FALSE(bucket.take(1.0, at(0.0)));
  EXPECT_FALSE(bucket.take(1.0, at(0.0625))) << "not a whole one";
  EXPECT_TRUE(bucket.take(5.0, at(0.5)));
  EXPECT_FALSE(bucket.take(1.0, at(0.5)));
  EXPECT_FALSE(bucket.take(20.5, at(100.0))) << "never more than the burst";
  EXPECT_TRUE(bucket.take(20.0, at(100.0)));
  bucket.give_back(30.0);
  EXPECT_TRUE(bucket.take(20.0, at(100.0)));
  EXPECT_FALSE(bucket.take(1.0, at(100.0)));
}

}  // namespace
}  // namespace kerf
