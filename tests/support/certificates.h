#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace kerf::test {

// Holds a certificate and its private key, both as PEM texts.
struct Identity {
  std::string certificate;
  std::string key;
};

// Says from when to when a certificate is valid, in seconds from now.
struct Validity {
  std::int64_t begin_s = -3600;
  std::int64_t end_s = 30 * 86'400;
};

// Issues certificates for one test. Keys are new ones, on the curve P-256.
class Authority {
 public:
  explicit Authority(const std::string& name, Validity validity = {});
  ~Authority();
  Authority(const Authority&) = delete;
  Authority& operator=(const Authority&) = delete;

  [[nodiscard]] const std::string& certificate() const { return certificate_; }
  // Issues a certificate for "localhost" and 127.0.0.1 with this common name.
  [[nodiscard]] Identity issue(const std::string& name, Validity validity = {}) const;

 private:
  struct Own;
  std::unique_ptr<Own> own_;
  std::string certificate_;
};

// Returns the private key with a password.
std::string with_password(const std::string& key, const std::string& password);

}  // namespace kerf::test
