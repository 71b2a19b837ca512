#pragma once

#include "client/cli/output.h"
#include "client/cpp/client.h"
#include "client/cpp/credentials.h"
#include "client/cpp/result.h"

namespace kerf::cli {

// Returns a client of the server. Throws client::CallFailed with the error of secrets_of().
client::Client connect(const ServerTarget& server);

// Reads the files of the server's credentials. Errors are those of client::read_secrets(), with the option of the
// command line, such as "--token-file", as their field.
client::Result<client::Secrets> secrets_of(const ServerTarget& server);

}  // namespace kerf::cli
