#pragma once

#include <memory>
#include <string>

#include <grpcpp/channel.h>

#include "client/cpp/client.h"
#include "client/cpp/result.h"

namespace kerf::client {

// Holds what Credentials name, read and checked.
struct Secrets {
  std::string token = {};  // Empty: none.
  bool use_tls = false;
  std::string authorities = {};  // PEM; empty: those of the system.
  std::string certificate = {};  // PEM; empty, as is `key`: none is shown.
  std::string key = {};          // PEM
  std::string tls_name = {};     // As in Credentials.
};

// Reads the files of the credentials, for calls to `address`. Errors are INVALID_ARGUMENT with the member of
// Credentials at fault as their field: CREDENTIALS_UNREADABLE, TOKEN_GIVEN_TWICE, TOKEN_MALFORMED, TOKEN_NEEDS_TLS,
// TLS_FILE_MALFORMED, TLS_PAIR_INCOMPLETE. No message has a part of a token or of a key.
Result<Secrets> read_secrets(const Credentials& credentials, const std::string& address);

// True if this machine itself has the address: one of 127.0.0.0/8, ::1, localhost, or a unix socket. `address` is as
// gRPC takes it, with a scheme or without.
[[nodiscard]] bool is_on_this_machine(const std::string& address);

// Makes the channel of a client. All calls on it, streams included, carry the token.
std::shared_ptr<grpc::Channel> open_channel(const std::string& address, const Secrets& secrets,
                                            Client::Connection connection);

}  // namespace kerf::client
