#include "tests/support/certificates.h"

#include <openssl/asn1.h>
#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <ctime>
#include <functional>

namespace kerf::test {
namespace {

template <auto release>
struct Free {
  template <typename Object>
  void operator()(Object* object) const {
    release(object);
  }
};
using Key = std::unique_ptr<EVP_PKEY, Free<EVP_PKEY_free>>;
using Signed = std::unique_ptr<X509, Free<X509_free>>;
using Memory = std::unique_ptr<BIO, Free<BIO_free>>;

std::string written(const std::function<void(BIO*)>& write) {
  const Memory memory(BIO_new(BIO_s_mem()));
  write(memory.get());
  char* begin = nullptr;
  const auto size = BIO_get_mem_data(memory.get(), &begin);
  return {begin, static_cast<std::size_t>(size)};
}

std::string pem_of(X509* certificate) {
  return written([certificate](BIO* to) { PEM_write_bio_X509(to, certificate); });
}

std::string pem_of(EVP_PKEY* key) {
  return written([key](BIO* to) { PEM_write_bio_PrivateKey(to, key, nullptr, nullptr, 0, nullptr, nullptr); });
}

void extend(X509* certificate, X509* issuer, int kind, const char* value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* const extension = X509V3_EXT_conf_nid(nullptr, &context, kind, value);
  X509_add_ext(certificate, extension, -1);
  X509_EXTENSION_free(extension);
}

// Makes a certificate without extensions and signature.
Signed begin_certificate(const std::string& name, EVP_PKEY* key, Validity validity) {
  Signed made(X509_new());
  X509_set_version(made.get(), X509_VERSION_3);
  std::uint64_t serial = 0;
  RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof(serial));
  ASN1_INTEGER_set_uint64(X509_get_serialNumber(made.get()), serial >> 1U);
  const std::time_t now = std::time(nullptr);
  ASN1_TIME_set(X509_getm_notBefore(made.get()), now + validity.begin_s);
  ASN1_TIME_set(X509_getm_notAfter(made.get()), now + validity.end_s);
  X509_NAME_add_entry_by_txt(X509_get_subject_name(made.get()), "CN", MBSTRING_UTF8,
                             reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1, 0);
  X509_set_pubkey(made.get(), key);
  return made;
}

void sign(X509* certificate, X509* issuer, EVP_PKEY* issuer_key) {
  X509_set_issuer_name(certificate, X509_get_subject_name(issuer));
  X509_sign(certificate, issuer_key, EVP_sha256());
}

}  // namespace

struct Authority::Own {
  Key key;
  Signed certificate;
};

Authority::Authority(const std::string& name, Validity validity)
    : own_(std::make_unique<Own>(Own{Key(EVP_EC_gen("P-256")), nullptr})) {
  own_->certificate = begin_certificate(name, own_->key.get(), validity);
  X509* const own = own_->certificate.get();
  extend(own, own, NID_basic_constraints, "critical,CA:TRUE");
  extend(own, own, NID_key_usage, "critical,keyCertSign,cRLSign");
  extend(own, own, NID_subject_key_identifier, "hash");
  sign(own, own, own_->key.get());
  certificate_ = pem_of(own);
}

Authority::~Authority() = default;

Identity Authority::issue(const std::string& name, Validity validity) const {
  const Key key(EVP_EC_gen("P-256"));
  X509* const issuer = own_->certificate.get();
  const Signed made = begin_certificate(name, key.get(), validity);
  extend(made.get(), issuer, NID_basic_constraints, "critical,CA:FALSE");
  extend(made.get(), issuer, NID_subject_alt_name, "DNS:localhost,IP:127.0.0.1");
  extend(made.get(), issuer, NID_authority_key_identifier, "keyid");
  sign(made.get(), issuer, own_->key.get());
  return {pem_of(made.get()), pem_of(key.get())};
}

std::string with_password(const std::string& key, const std::string& password) {
  const Memory text(BIO_new_mem_buf(key.data(), static_cast<int>(key.size())));
  const Key read(PEM_read_bio_PrivateKey(text.get(), nullptr, nullptr, nullptr));
  return written([&](BIO* to) {
    PEM_write_bio_PKCS8PrivateKey(to, read.get(), EVP_aes_256_cbc(), password.data(), static_cast<int>(password.size()),
                                  nullptr, nullptr);
  });
}

}  // namespace kerf::test
