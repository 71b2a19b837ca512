// Logins of browsers and links.

#include "server/service/auth/logins.h"

#include <gtest/gtest.h>

namespace kerf::auth {
namespace {

class LoginsTest : public testing::Test {
 protected:
  std::shared_ptr<Grant> grant(Scope scope = Scope::kCut, std::int64_t until = 0) {
    return std::make_shared<Grant>("alice", Rights{scope, "*", until}, clock_);
  }
  Caller token(Scope scope = Scope::kCut, std::int64_t until = 0) { return {grant(scope, until), {}}; }
  LinkTerms terms(std::int64_t seconds, bool once = false) { return {{Scope::kView, "demo", now_ + seconds}, once}; }

  std::int64_t now_ = 1'000'000;
  const UnixClock clock_ = [this] { return now_; };
  Logins logins_{clock_};
};

TEST_F(LoginsTest, LastTwelveHours) {
  const std::string secret = logins_.begin(token()).value();
  const Caller caller = logins_.find(secret).value();
  EXPECT_EQ(caller->token_id(), "alice");
  EXPECT_EQ(caller->rights().scope, Scope::kCut);
  EXPECT_EQ(caller->ends_at(), now_ + kLoginSeconds);
  now_ += kLoginSeconds - 1;
  EXPECT_TRUE(logins_.find(secret).ok());
  now_ += 1;
  EXPECT_EQ(logins_.find(secret).error().reason, "TOKEN_EXPIRED");
  EXPECT_EQ(caller->check().error().reason, "TOKEN_EXPIRED") << "a stream that is open ends, too";
  EXPECT_EQ(logins_.find("another").error().reason, "LOGIN_UNKNOWN");
}

TEST_F(LoginsTest, EndWithTheirTokenAndWithALogout) {
  const std::shared_ptr<Grant> of_alice = grant();
  const Caller alice{of_alice, {}}, bob = token(Scope::kAdmin, now_ + 60);
  const std::string first = logins_.begin(alice).value(), second = logins_.begin(alice).value(),
                    third = logins_.begin(bob).value();
  const Caller held = logins_.find(first).value();
  logins_.end(first);
  logins_.end("none");
  EXPECT_EQ(held->check().error().reason, "TOKEN_UNKNOWN");
  EXPECT_EQ(logins_.find(first).error().reason, "LOGIN_UNKNOWN");
  EXPECT_TRUE(logins_.find(second).ok()) << "another browser stays";
  of_alice->withdraw();
  EXPECT_EQ(logins_.find(second).error().reason, "TOKEN_UNKNOWN");
  EXPECT_EQ(logins_.find(third).value()->ends_at(), now_ + 60);
  now_ += 60;
  EXPECT_EQ(logins_.find(third).error().reason, "TOKEN_EXPIRED");
}

TEST_F(LoginsTest, LinksGiveWhatTheySay) {
  const auto alice = token();
  const std::string code = logins_.make_link(alice, terms(3600)).value();
  now_ += 1800;
  const std::string first = logins_.open_link(code).value(), second = logins_.open_link(code).value();
  EXPECT_NE(first, second);
  const Caller caller = logins_.find(first).value();
  EXPECT_EQ(caller->rights().scope, Scope::kView);
  EXPECT_EQ(caller->rights().sheets, "demo");
  EXPECT_EQ(caller->ends_at(), 1'003'600);
  EXPECT_EQ(caller->token_id(), "alice");
  now_ += 1800;
  EXPECT_EQ(logins_.find(second).error().reason, "TOKEN_EXPIRED");
  EXPECT_EQ(logins_.open_link(code).error().reason, "CODE_UNKNOWN");
}

TEST_F(LoginsTest, ALinkThatIsOpenedOnceIsOpenForAMinute) {
  const std::string code = logins_.make_link(token(), terms(3600, true)).value(),
                    late = logins_.make_link(token(), terms(3600, true)).value();
  now_ += kLinkOnceSeconds - 1;
  const std::string login = logins_.open_link(code).value();
  EXPECT_EQ(logins_.open_link(code).error().reason, "CODE_UNKNOWN");
  now_ += 1;
  EXPECT_EQ(logins_.open_link(late).error().reason, "CODE_UNKNOWN");
  EXPECT_TRUE(logins_.find(login).ok());
}

TEST_F(LoginsTest, LinksEndWithTheirToken) {
  const std::shared_ptr<Grant> of_alice = grant();
  const Caller alice{of_alice, {}};
  const std::string code = logins_.make_link(alice, terms(3600)).value();
  const Caller caller = logins_.find(logins_.open_link(code).value()).value();
  of_alice->withdraw();
  EXPECT_EQ(logins_.open_link(code).error().reason, "CODE_UNKNOWN");
  EXPECT_EQ(caller->check().error().reason, "TOKEN_UNKNOWN");
}

TEST_F(LoginsTest, AreBoundedAndForgetOldOnes) {
  const auto of = [this](std::size_t number) {
    return Caller{std::make_shared<Grant>("t" + std::to_string(number), Rights{Scope::kCut, "*", 0}, clock_), {}};
  };
  for (std::size_t i = 0; i < kMaxLogins; ++i) ASSERT_TRUE(logins_.begin(of(i / kMaxLoginsOfToken)).ok());
  for (std::size_t i = 0; i < kMaxLinks; ++i) {
    ASSERT_TRUE(logins_.make_link(of(i / kMaxLinksOfToken), terms(3600)).ok());
  }
  EXPECT_EQ(logins_.begin(of(99)).error().reason, "TOO_MANY_LOGINS");
  EXPECT_EQ(logins_.make_link(of(99), terms(3600)).error().reason, "TOO_MANY_LINKS");
  now_ += kLoginSeconds;
  EXPECT_TRUE(logins_.begin(of(99)).ok());
  EXPECT_TRUE(logins_.make_link(of(99), terms(3600)).ok());
}

TEST_F(LoginsTest, OneTokenDoesNotTakeThemAll) {
  const Caller alice = token();
  const Caller bob{std::make_shared<Grant>("bob", Rights{Scope::kCut, "*", 0}, clock_), {}};
  for (std::size_t i = 0; i < kMaxLoginsOfToken; ++i) ASSERT_TRUE(logins_.begin(alice).ok());
  for (std::size_t i = 0; i < kMaxLinksOfToken; ++i) ASSERT_TRUE(logins_.make_link(alice, terms(3600)).ok());
  EXPECT_EQ(logins_.begin(alice).error().reason, "TOO_MANY_LOGINS");
  EXPECT_EQ(logins_.make_link(alice, terms(3600)).error().reason, "TOO_MANY_LINKS");
  EXPECT_TRUE(logins_.begin(bob).ok());
  EXPECT_TRUE(logins_.make_link(bob, terms(3600)).ok());
}

}  // namespace
}  // namespace kerf::auth
