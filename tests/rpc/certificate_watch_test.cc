// Notes to the operator about the end of a certificate.

#include "server/app/certificate_watch.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/manual_clock.h"

namespace kerf::app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::int64_t kSecondsOfADay = 86'400;

TEST(ExpiryNote, BeginsFourteenDaysBefore) {
  EXPECT_FALSE(expiry_note("--tls-cert", "a.pem", 20 * kSecondsOfADay, 6 * kSecondsOfADay));
  EXPECT_EQ(expiry_note("--tls-cert", "a.pem", 20 * kSecondsOfADay, 6 * kSecondsOfADay + 1).value(),
            "--tls-cert: \"a.pem\" expires in 13 days, at 1970-01-21 00:00:00 UTC; renew it");
  EXPECT_THAT(expiry_note("--tls-cert", "a.pem", 20 * kSecondsOfADay, 19 * kSecondsOfADay).value(),
              HasSubstr("in 1 day,"));
  EXPECT_THAT(expiry_note("--tls-cert", "a.pem", 20 * kSecondsOfADay, 20 * kSecondsOfADay).value(),
              HasSubstr("has expired"));
}

TEST(CertificateWatch, LooksOnceADay) {
  test::ManualClock clock;
  std::vector<std::string> notes;
  const auto days_pass = [&](int count) {
    for (int i = 0; i < count; ++i) clock.move_to(clock.now() + std::chrono::hours(24));
    return std::exchange(notes, {});
  };
  CertificateWatch watch(clock, [&notes](std::string_view text) { notes.emplace_back(text); });
  EXPECT_EQ(watch.end_s(), 0);
  EXPECT_THAT(days_pass(30), IsEmpty()) << "there is none";
  const std::int64_t now_s = clock.unix_us() / 1'000'000;
  watch.set("a.pem", now_s + 16 * kSecondsOfADay);
  EXPECT_THAT(days_pass(2), IsEmpty());
  EXPECT_THAT(days_pass(1), ElementsAre(HasSubstr("expires in 13 days")));
  EXPECT_EQ(days_pass(12).size(), 12u);
  EXPECT_THAT(days_pass(1), ElementsAre(HasSubstr("has expired")));
  watch.set("b.pem", now_s + 100 * kSecondsOfADay);
  EXPECT_THAT(days_pass(10), IsEmpty());
}

}  // namespace
}  // namespace kerf::app
