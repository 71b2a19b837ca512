#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/service/host/clock.h"

namespace kerf::app {

// Returns what the operator should know about a certificate of `option` that ends at `end_s`, as of `now_s`, both in s
// since 1970; nothing while it is good for 14 days.
std::optional<std::string> expiry_note(const std::string& option, const std::string& path, std::int64_t end_s,
                                       std::int64_t now_s);

// Notes once a day that the server's certificate ends soon, or has ended. Thread-safe.
class CertificateWatch {
 public:
  // `clock` must outlive this; `note` is called on its thread, and not after this was destroyed.
  CertificateWatch(host::Clock& clock, std::function<void(std::string_view)> note);
  ~CertificateWatch();
  CertificateWatch(const CertificateWatch&) = delete;
  CertificateWatch& operator=(const CertificateWatch&) = delete;

  // Watches this certificate of --tls-cert from now on. `end_s`: s since 1970.
  void set(const std::string& path, std::int64_t end_s);
  // Returns the end of the certificate, s since 1970; 0: there is none.
  [[nodiscard]] std::int64_t end_s() const;

 private:
  struct State;

  const std::shared_ptr<State> state_;  // Timers may fire after this is gone.
};

}  // namespace kerf::app
