#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "server/base/disk.h"
#include "server/base/result.h"
#include "server/service/auth/token_file.h"

namespace kerf::app {

// Names the files of --tls-cert, --tls-key and --tls-client-ca; empty: not given.
struct CertificateFiles {
  std::string certificate;
  std::string key;
  std::string client_authorities;

  [[nodiscard]] bool used() const { return !certificate.empty(); }
};

// Holds what the files of certificates say, as PEM texts.
struct Certificates {
  std::string chain;
  std::string key;
  std::string client_authorities;  // Empty: clients need no certificate.
  std::int64_t end_s = 0;          // s since 1970, when the server's own ends
  std::vector<std::string> notes;  // For the operator: certificates that expire soon, or are not valid yet.
};

// Reads and checks the files; `files.used()` must be true. `now_s`: seconds since 1970. Errors are kInvalidArgument,
// and name the option and the file: BAD_CERTIFICATE_FILE (cannot be read), BAD_CERTIFICATE, BAD_KEY (no PEM, damaged,
// or with a password), KEY_DOES_NOT_FIT, CERTIFICATE_EXPIRED. Some authorities may have expired, but not all.
Result<Certificates> read_certificates(const CertificateFiles& files, Disk& disk, std::int64_t now_s);

// Reads a file of tokens. Errors are kInvalidArgument, and name the option and the file.
Result<auth::TokenFile> read_token_file(const std::filesystem::path& file, Disk& disk);

}  // namespace kerf::app
