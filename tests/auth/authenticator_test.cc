// Tokens become grants, and end with their line in the file.

#include "server/service/auth/authenticator.h"

#include <gtest/gtest.h>

namespace kerf::auth {
namespace {

class AuthenticatorTest : public testing::Test {
 protected:
  AuthenticatorTest() { set({alice_.line, bob_.line}); }
  void set(const std::vector<std::string>& lines) {
    std::string file;
    for (const std::string& line : lines) file += line + "\n";
    authenticator_.set_tokens(parse_token_file(file).value().tokens);
  }
  std::string refusal(const std::string& authorization) {
    const auto caller = authenticator_.find_bearer(authorization);
    return caller.ok() ? "" : caller.error().reason;
  }

  const NewToken alice_ = make_token({"alice", Scope::kCut, "", "", ""}).value();
  const NewToken bob_ = make_token({"bob", Scope::kView, "lab-*", "1971-01-02", ""}).value();
  std::int64_t now_ = 365 * 86'400;  // 1971-01-01
  Authenticator authenticator_{[this] { return now_; }};
};

TEST_F(AuthenticatorTest, KnowsTheTokensOfItsFile) {
  EXPECT_EQ(authenticator_.find(alice_.text).value()->token_id(), "alice");
  const Caller bob = authenticator_.find_bearer("Bearer " + bob_.text).value();
  EXPECT_EQ(bob->rights().scope, Scope::kView);
  EXPECT_TRUE(bob->rights().reaches("lab-1"));
  EXPECT_FALSE(bob->rights().reaches("demo"));
  EXPECT_EQ(authenticator_.find_bearer("bEARER " + alice_.text).value()->token_id(), "alice");
  now_ += 86'400;
  EXPECT_EQ(refusal("Bearer " + bob_.text), "TOKEN_EXPIRED");
}

TEST_F(AuthenticatorTest, RefusesAllElse) {
  for (const std::string& none :
       {std::string(), std::string("Bearer"), "Basic " + alice_.text, alice_.text, "Bearer" + alice_.text}) {
    EXPECT_EQ(refusal(none), "TOKEN_MISSING") << none;
  }
  std::string near = alice_.text;
  near.back() = near.back() == 'A' ? 'B' : 'A';
  const NewToken stranger = make_token({"alice", Scope::kAdmin, "", "", ""}).value();
  for (const std::string& wrong : {std::string(), near, stranger.text, " " + alice_.text, alice_.text + " ",
                                   std::string("kerf_alice_"), alice_.text.substr(0, 20)}) {
    EXPECT_EQ(refusal("Bearer " + wrong), "TOKEN_UNKNOWN") << wrong;
  }
}

TEST_F(AuthenticatorTest, WithdrawsWhatIsGoneOrChanged) {
  const Caller alice = authenticator_.find(alice_.text).value();
  const Caller bob = authenticator_.find(bob_.text).value();
  const Caller login = authenticator_.logins().find(authenticator_.logins().begin(bob).value()).value();
  set({alice_.line});
  EXPECT_TRUE(alice->check().ok());
  EXPECT_EQ(bob->check().error().reason, "TOKEN_UNKNOWN");
  EXPECT_EQ(login->check().error().reason, "TOKEN_UNKNOWN");
  EXPECT_EQ(refusal("Bearer " + bob_.text), "TOKEN_UNKNOWN");
  set({alice_.line + " sheets=lab-*"});
  EXPECT_EQ(alice->check().error().reason, "TOKEN_UNKNOWN") << "its rights are others now";
  EXPECT_EQ(authenticator_.find(alice_.text).value()->rights().sheets, "lab-*");
}

TEST_F(AuthenticatorTest, EverybodyMayDoEverything) {
  EXPECT_TRUE(everybody()->check().ok());
  EXPECT_EQ(everybody()->rights().scope, Scope::kAdmin);
  EXPECT_TRUE(everybody()->rights().reaches_all());
  EXPECT_EQ(everybody()->ends_at(), 0);
}

}  // namespace
}  // namespace kerf::auth
