// The files of certificates: what is wrong with them, and what the operator hears.

#include "server/app/certificates.h"

#include <gtest/gtest.h>

#include <ctime>
#include <string>

#include "tests/support/certificates.h"
#include "tests/support/memory_disk.h"

namespace kerf::app {
namespace {

constexpr std::int64_t kDay = 86'400;

class CertificatesTest : public ::testing::Test {
 protected:
  void write(const std::string& path, const std::string& content) { ASSERT_TRUE(disk_.write_file(path, content).ok()); }
  void use(const test::Identity& identity) {
    write("server.pem", identity.certificate);
    write("server.key", identity.key);
  }
  Result<Certificates> read(const std::string& client_authorities = "", std::int64_t later_s = 0) {
    return read_certificates({"server.pem", "server.key", client_authorities}, disk_, std::time(nullptr) + later_s);
  }
  // Expects a refusal that names option and file.
  void expect_refusal(const Result<Certificates>& outcome, const std::string& reason, const std::string& option,
                      const std::string& says) {
    ASSERT_FALSE(outcome.ok()) << reason;
    const Error& error = outcome.error();
    EXPECT_EQ(error.reason, reason) << error.message;
    EXPECT_EQ(error.field, option);
    EXPECT_TRUE(error.message.starts_with(option + ": ")) << error.message;
    EXPECT_NE(error.message.find(says), std::string::npos) << error.message;
  }

  test::MemoryDisk disk_;
  const test::Authority authority_{"Kerf test authority"};
  const test::Identity good_ = authority_.issue("localhost");
};

TEST_F(CertificatesTest, AreReadAsTheyAre) {
  const std::string chain = good_.certificate + authority_.certificate();
  use({chain, good_.key});
  write("clients.pem", authority_.certificate());
  const Result<Certificates> found = read("clients.pem");
  ASSERT_TRUE(found.ok()) << found.error().message;
  EXPECT_EQ(found->chain, chain);
  EXPECT_EQ(found->key, good_.key);
  EXPECT_EQ(found->client_authorities, authority_.certificate());
  EXPECT_TRUE(found->notes.empty()) << found->notes.front();
}

TEST_F(CertificatesTest, MissingFilesAreNamed) {
  expect_refusal(read(), "BAD_CERTIFICATE_FILE", "--tls-cert", "server.pem");
  write("server.pem", good_.certificate);
  expect_refusal(read(), "BAD_CERTIFICATE_FILE", "--tls-key", "server.key");
  write("server.key", good_.key);
  expect_refusal(read("none.pem"), "BAD_CERTIFICATE_FILE", "--tls-client-ca", "none.pem");
}

TEST_F(CertificatesTest, WhatIsNoPemIsRefused) {
  use({"a word", good_.key});
  expect_refusal(read(), "BAD_CERTIFICATE", "--tls-cert", "no certificate in PEM form");
  use({good_.key, good_.key});
  expect_refusal(read(), "BAD_CERTIFICATE", "--tls-cert", "no certificate in PEM form");
  std::string damaged = authority_.certificate();
  damaged[damaged.size() / 2] = '*';
  use({good_.certificate + damaged, good_.key});
  expect_refusal(read(), "BAD_CERTIFICATE", "--tls-cert", "its certificate 2 cannot be read");
  use({good_.certificate, good_.certificate});
  expect_refusal(read(), "BAD_KEY", "--tls-key", "no private key in PEM form");
  use({good_.certificate, test::with_password(good_.key, "secret")});
  expect_refusal(read(), "BAD_KEY", "--tls-key", "with a password");
  use(good_);
  write("clients.pem", "");
  expect_refusal(read("clients.pem"), "BAD_CERTIFICATE", "--tls-client-ca", "no certificate in PEM form");
}

TEST_F(CertificatesTest, TheKeyIsThatOfTheFirstCertificate) {
  use({good_.certificate, authority_.issue("localhost").key});
  expect_refusal(read(), "KEY_DOES_NOT_FIT", "--tls-key", "server.pem");
  use({authority_.certificate() + good_.certificate, good_.key});
  expect_refusal(read(), "KEY_DOES_NOT_FIT", "--tls-key", "server.key");
}

TEST_F(CertificatesTest, OneThatExpiresSoonIsNotedAndOneThatHasExpiredRefused) {
  use(authority_.issue("localhost", {.end_s = 20 * kDay}));
  const Certificates good = read("", 5 * kDay).value();
  EXPECT_TRUE(good.notes.empty());
  EXPECT_NEAR(static_cast<double>(good.end_s - std::time(nullptr)), 20.0 * kDay, 600.0);
  const Result<Certificates> soon = read("", 7 * kDay);
  ASSERT_TRUE(soon.ok()) << soon.error().message;
  ASSERT_EQ(soon->notes.size(), 1U);
  EXPECT_NE(soon->notes.front().find("--tls-cert: \"server.pem\" expires in 1"), std::string::npos)
      << soon->notes.front();
  expect_refusal(read("", 21 * kDay), "CERTIFICATE_EXPIRED", "--tls-cert", "has expired");
  const Result<Certificates> early = read("", -2 * kDay);
  ASSERT_TRUE(early.ok()) << early.error().message;
  ASSERT_EQ(early->notes.size(), 1U);
  EXPECT_NE(early->notes.front().find("is valid only from"), std::string::npos) << early->notes.front();
}

TEST_F(CertificatesTest, AnAuthorityThatHasExpiredIsOfNoUseAlone) {
  use(good_);
  const test::Authority old("Old authority", {.begin_s = -2 * kDay, .end_s = -kDay});
  write("clients.pem", old.certificate());
  expect_refusal(read("clients.pem"), "CERTIFICATE_EXPIRED", "--tls-client-ca", "expired");
  write("clients.pem", old.certificate() + authority_.certificate());
  EXPECT_TRUE(read("clients.pem").ok());
}

}  // namespace
}  // namespace kerf::app
