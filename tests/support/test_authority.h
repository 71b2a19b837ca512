#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/support/temporary_folder.h"

namespace kerf::test {

// An authority made for a test, with the certificates that it signs, by the command openssl.
class TestAuthority {
 public:
  // Paths of PEM files.
  struct Pair {
    std::string certificate;
    std::string key;
  };

  TestAuthority() { openssl("-x509 -subj '/CN=Authority of a test'", "ca"); }

  [[nodiscard]] std::string ca() const { return file("ca.pem"); }
  [[nodiscard]] std::string file(const std::string& name) const { return (folder_ / name).string(); }

  // Signs a certificate. `names`: "IP:127.0.0.1,DNS:localhost".
  [[nodiscard]] Pair make(const std::string& name, const std::string& names = "IP:127.0.0.1,DNS:localhost") const {
    openssl(
        "-x509 -CA " + ca() + " -CAkey " + file("ca.key") + " -subj /CN=" + name + " -addext subjectAltName=" + names,
        name);
    return {file(name + ".pem"), file(name + ".key")};
  }

  static std::string content_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

 private:
  void openssl(const std::string& options, const std::string& name) const {
    const std::string command = "openssl req -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -batch -days 2 " +
                                options + " -keyout " + file(name + ".key") + " -out " + file(name + ".pem") +
                                " 2> /dev/null";
    EXPECT_EQ(std::system(command.c_str()), 0) << command;  // NOLINT(concurrency-mt-unsafe)
  }

  TemporaryFolder folder_;
};

}  // namespace kerf::test
