// Patterns of ids and what a scope includes.

#include "server/service/auth/rights.h"

#include <gtest/gtest.h>

namespace kerf::auth {
namespace {

TEST(Rights, PatternsFitWholeIds) {
  for (const auto& [pattern, text] :
       {std::pair("*", ""), std::pair("*", "demo"), std::pair("demo", "demo"), std::pair("lab-*", "lab-"),
        std::pair("lab-*", "lab-a-b"), std::pair("*-a", "b-a-a"), std::pair("a*b*c", "abbcbc"), std::pair("?", "a"),
        std::pair("a?c", "abc"), std::pair("**a", "a"), std::pair("", "")}) {
    EXPECT_TRUE(matches(pattern, text)) << pattern << " " << text;
  }
  for (const auto& [pattern, text] : {std::pair("demo", "demo2"), std::pair("demo", "dem"), std::pair("lab-*", "lab"),
                                      std::pair("?", ""), std::pair("?", "ab"), std::pair("a*b*c", "abcb"),
                                      std::pair("", "a"), std::pair("lab-*", "xlab-a"), std::pair("LAB", "lab")}) {
    EXPECT_FALSE(matches(pattern, text)) << pattern << " " << text;
  }
}

// The time of a comparison must not explode, as a token's pattern is compared for each sheet of a list.
TEST(Rights, ManyStarsAreComparedInPolynomialTime) {
  std::string pattern, text(62, 'a');
  for (int i = 0; i < 60; ++i) pattern += "*a";
  EXPECT_FALSE(matches(pattern + "*b", text));
}

TEST(Rights, ScopesHaveNames) {
  for (const Scope scope : {Scope::kView, Scope::kCut, Scope::kAdmin}) EXPECT_EQ(scope_named(name_of(scope)), scope);
  EXPECT_FALSE(scope_named("root"));
  EXPECT_LT(Scope::kView, Scope::kCut);
  EXPECT_LT(Scope::kCut, Scope::kAdmin);
}

TEST(Rights, EndAtTheirTime) {
  Rights rights;
  EXPECT_FALSE(rights.is_over(1'000'000'000'000));
  rights.until_unix_s = 100;
  EXPECT_FALSE(rights.is_over(99));
  EXPECT_TRUE(rights.is_over(100));
}

}  // namespace
}  // namespace kerf::auth
