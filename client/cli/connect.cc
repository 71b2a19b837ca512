#include "client/cli/connect.h"

#include <algorithm>

namespace kerf::cli {

client::Client connect(const ServerTarget& server) {
  const client::Result<client::Secrets> secrets = secrets_of(server);
  if (!secrets) throw client::CallFailed(secrets.failure());
  return client::Client(client::open_channel(server.address, *secrets, client::Client::Connection::kShared));
}

client::Result<client::Secrets> secrets_of(const ServerTarget& server) {
  client::Result<client::Secrets> secrets = client::read_secrets(server.credentials, server.address);
  if (secrets) return secrets;
  client::Failure failure = secrets.failure();
  std::replace(failure.field.begin(), failure.field.end(), '_', '-');  // The member token_file is set by --token-file.
  failure.field.insert(0, "--");
  return failure;
}

}  // namespace kerf::cli
