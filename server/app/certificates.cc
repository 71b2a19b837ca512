#include "server/app/certificates.h"

#include <openssl/asn1.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/pemerr.h>
#include <openssl/x509.h>

#include <algorithm>
#include <cstddef>
#include <ctime>
#include <memory>
#include <optional>
#include <utility>

#include "server/app/certificate_watch.h"

namespace kerf::app {
namespace {

constexpr std::size_t kMostCertificateBytes = std::size_t{1} << 20;

template <auto release>
struct Release {
  template <typename Object>
  void operator()(Object* object) const {
    release(object);
  }
};
using Bio = std::unique_ptr<BIO, Release<BIO_free>>;
using Certificate = std::unique_ptr<X509, Release<X509_free>>;
using PrivateKey = std::unique_ptr<EVP_PKEY, Release<EVP_PKEY_free>>;

// Describes one file: its option, its name for messages, and its content.
struct PemFile {
  std::string option;
  std::string path;
  std::string text;

  [[nodiscard]] Error fault(std::string reason, const std::string& message) const {
    return invalid_argument(std::move(reason), option + ": \"" + path + "\" " + message, option);
  }
  [[nodiscard]] Bio open() const { return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size()))); }
};

Result<PemFile> read_pem(const std::string& option, const std::string& path, Disk& disk) {
  Result<std::string> text = disk.read_file(path, kMostCertificateBytes);
  if (!text.ok()) return invalid_argument("BAD_CERTIFICATE_FILE", option + ": " + text.error().message, option);
  return PemFile{option, path, std::move(*text)};
}

// Refuses a password, for which OpenSSL would ask on the terminal.
int no_password(char* /*buffer*/, int /*size*/, int /*writing*/, void* /*context*/) {
  return -1;
}

// Returns all certificates of a file, at least one.
Result<std::vector<Certificate>> parse_certificates(const PemFile& file) {
  ERR_clear_error();
  const Bio bio = file.open();
  std::vector<Certificate> found;
  while (Certificate next{PEM_read_bio_X509(bio.get(), nullptr, no_password, nullptr)})
    found.push_back(std::move(next));
  const bool at_end = ERR_GET_REASON(ERR_peek_last_error()) == PEM_R_NO_START_LINE;
  ERR_clear_error();
  if (!at_end) {
    return file.fault("BAD_CERTIFICATE",
                      "is damaged: its certificate " + std::to_string(found.size() + 1) + " cannot be read");
  }
  if (found.empty()) {
    return file.fault("BAD_CERTIFICATE", "has no certificate in PEM form (-----BEGIN CERTIFICATE-----)");
  }
  return found;
}

Result<PrivateKey> parse_key(const PemFile& file) {
  ERR_clear_error();
  const Bio bio = file.open();
  PrivateKey key(PEM_read_bio_PrivateKey(bio.get(), nullptr, no_password, nullptr));
  ERR_clear_error();
  if (key) return key;
  if (file.text.find("ENCRYPTED") != std::string::npos) {
    return file.fault("BAD_KEY", "has a key with a password, and kerfd asks for none: take it off with openssl pkey");
  }
  return file.fault("BAD_KEY", "has no private key in PEM form (-----BEGIN PRIVATE KEY-----) that can be read");
}

// Returns a time in seconds since 1970.
std::int64_t seconds_of(const ASN1_TIME* time) {
  std::tm parts{};
  ASN1_TIME_to_tm(time, &parts);
  return timegm(&parts);
}

bool has_expired(const Certificate& certificate, std::int64_t now_s) {
  return seconds_of(X509_get0_notAfter(certificate.get())) <= now_s;
}

std::string date_of(const ASN1_TIME* time) {
  const Bio text(BIO_new(BIO_s_mem()));
  ASN1_TIME_print(text.get(), time);
  char* begin = nullptr;
  const auto size = BIO_get_mem_data(text.get(), &begin);
  return {begin, static_cast<std::size_t>(size)};
}

// Checks the server's own certificate, and notes what the operator should do soon.
Status check_dates(const PemFile& file, const Certificate& own, std::int64_t now_s, Certificates& read) {
  const ASN1_TIME* const end = X509_get0_notAfter(own.get());
  if (has_expired(own, now_s)) {
    return file.fault("CERTIFICATE_EXPIRED", "has expired, at " + date_of(end) + "; renew it");
  }
  std::optional<std::string> soon = expiry_note(file.option, file.path, seconds_of(end), now_s);
  if (soon) read.notes.push_back(std::move(*soon));
  read.end_s = seconds_of(end);
  const ASN1_TIME* const begin = X509_get0_notBefore(own.get());
  if (seconds_of(begin) > now_s) {
    read.notes.push_back(file.option + ": \"" + file.path + "\" is valid only from " + date_of(begin));
  }
  return Nothing{};
}

Status check_pair(const PemFile& certificate, const PemFile& key, const Certificate& own) {
  KERF_TRY_ASSIGN(const PrivateKey private_key, parse_key(key));
  const bool fits = X509_check_private_key(own.get(), private_key.get()) == 1;
  ERR_clear_error();
  if (fits) return Nothing{};
  return key.fault("KEY_DOES_NOT_FIT",
                   "is not the key of the first certificate in --tls-cert \"" + certificate.path + "\"");
}

Result<std::string> read_authorities(const std::string& path, Disk& disk, std::int64_t now_s) {
  KERF_TRY_ASSIGN(PemFile file, read_pem("--tls-client-ca", path, disk));
  KERF_TRY_ASSIGN(const std::vector<Certificate> all, parse_certificates(file));
  const bool none_is_valid =
      std::ranges::all_of(all, [now_s](const Certificate& each) { return has_expired(each, now_s); });
  if (none_is_valid) return file.fault("CERTIFICATE_EXPIRED", "has only authorities that have expired");
  return std::move(file.text);
}

}  // namespace

Result<Certificates> read_certificates(const CertificateFiles& files, Disk& disk, std::int64_t now_s) {
  KERF_TRY_ASSIGN(PemFile certificate, read_pem("--tls-cert", files.certificate, disk));
  KERF_TRY_ASSIGN(PemFile key, read_pem("--tls-key", files.key, disk));
  KERF_TRY_ASSIGN(const std::vector<Certificate> chain, parse_certificates(certificate));
  KERF_TRY(check_pair(certificate, key, chain.front()));
  Certificates read;
  KERF_TRY(check_dates(certificate, chain.front(), now_s, read));
  if (!files.client_authorities.empty()) {
    KERF_TRY_ASSIGN(read.client_authorities, read_authorities(files.client_authorities, disk, now_s));
  }
  read.chain = std::move(certificate.text);
  read.key = std::move(key.text);
  return read;
}

Result<auth::TokenFile> read_token_file(const std::filesystem::path& file, Disk& disk) {
  const auto fault = [&file](const Error& error) {
    return invalid_argument(error.reason, "--tokens: \"" + file.string() + "\": " + error.message, "--tokens");
  };
  const Result<std::string> text = disk.read_file(file.string(), auth::kMaxTokenFileBytes);
  if (!text.ok()) return fault(text.error());
  Result<auth::TokenFile> parsed = auth::parse_token_file(*text);
  if (!parsed.ok()) return fault(parsed.error());
  return parsed;
}

}  // namespace kerf::app
