// TLS of the kerfd that ships: its options, its certificates and SIGHUP.

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/rpc/kerfd_process.h"
#include "tests/support/certificates.h"
#include "tests/ws/tls_client.h"

namespace kerf::rpc_test {
namespace {

using ws_test::TlsClient;
using ws_test::TlsOffer;

class KerfdTlsTest : public KerfdTest {
 protected:
  void use(const test::Identity& identity) const {
    write("server.pem", identity.certificate);
    write("server.key", identity.key);
  }
  [[nodiscard]] std::vector<std::string> with_tls(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"--tls-cert", cert_, "--tls-key", key_});
    return free_ports(std::move(more));
  }

  const test::Authority authority_{"Kerf test authority"};
  const std::string cert_ = (folder_ / "server.pem").string();
  const std::string key_ = (folder_ / "server.key").string();
};

TEST_F(KerfdTlsTest, RefusesOptionsThatDoNotGoTogether) {
  use(authority_.issue("localhost"));
  EXPECT_NE(refusal(free_ports({"--tls-cert", cert_})).find("--tls-key"), std::string::npos);
  EXPECT_NE(refusal(free_ports({"--tls-key", key_})).find("--tls-cert"), std::string::npos);
  EXPECT_NE(refusal(free_ports({"--tls-client-ca", cert_})).find("--tls-cert"), std::string::npos);
  EXPECT_NE(refusal(free_ports({"--tls-cert", "", "--tls-key", ""})).find("is empty"), std::string::npos);
  const std::string reached = refusal({"--listen", "127.0.0.1:0", "--http", "0.0.0.0:0", "--tls-cert", cert_,
                                       "--tls-key", key_, "--tokens", cert_, "--behind-proxy"});
  EXPECT_NE(reached.find("--behind-proxy: others could come without the proxy"), std::string::npos) << reached;
  write("server.pem", "nothing");
  const std::string bad = refusal(with_tls());
  EXPECT_NE(bad.find("--tls-cert: \"" + cert_ + "\" has no certificate"), std::string::npos) << bad;
}

TEST_F(KerfdTlsTest, SpeaksTlsAndReadsItsCertificateAgainOnSighup) {
  use(authority_.issue("localhost", {.end_s = 2 * 86'400 - 600}));
  Kerfd kerfd(with_tls());
  const std::string line = kerfd.read_line();
  EXPECT_NE(line.find(R"("http":"https://127.0.0.1:)"), std::string::npos) << line;
  const int port = std::stoi(line.substr(line.rfind(':') + 1));
  EXPECT_EQ(TlsClient(port, {.authority = authority_.certificate()}).failure(), "");
  const test::Authority next("Next authority");
  use(next.issue("localhost"));
  kerfd.signal(SIGHUP);
  const TlsOffer trusting{.authority = next.certificate()};
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(kPatienceMs);
  while (!TlsClient(port, trusting).failure().empty()) ASSERT_LT(std::chrono::steady_clock::now(), end);
  kerfd.signal(SIGTERM);
  EXPECT_EQ(kerfd.wait(), 0);
  const std::string errors = kerfd.errors();
  EXPECT_NE(errors.find("--tls-cert: \"" + cert_ + "\" expires in 1 day,"), std::string::npos) << errors;
  EXPECT_NE(errors.find("the certificate was read again"), std::string::npos) << errors;
}

TEST_F(KerfdTlsTest, WithoutFilesToReadAgainSighupStopsIt) {
  Kerfd kerfd(free_ports());
  ASSERT_NE(kerfd.read_line(), "");
  kerfd.signal(SIGHUP);
  EXPECT_EQ(kerfd.wait(), 0);
}

// As with nohup, whose programs outlive their terminal.
TEST_F(KerfdTlsTest, WhereSighupIsIgnoredItStopsNothing) {
  Kerfd kerfd(free_ports(), "-n 1024; trap '' HUP");
  const int port = ports(kerfd).second;
  kerfd.signal(SIGHUP);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_EQ(ws_test::request(port, "GET", "/healthz").status, 200);
  kerfd.signal(SIGTERM);
  EXPECT_EQ(kerfd.wait(), 0);
}

}  // namespace
}  // namespace kerf::rpc_test
