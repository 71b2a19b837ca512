#pragma once

#include "client/cli/connect.h"
#include "client/cli/output.h"
#include "client/cpp/client.h"

namespace kerf::cli {

// Makes a call of InteractionService and prints its outcome. Returns kDone or the exit code of a refusal.
template <typename Request>
int interact(const Session& session,
             grpc::Status (v1::InteractionService::Stub::*method)(grpc::ClientContext*, const Request&,
                                                                  v1::InteractionResponse*),
             const Request& request) {
  client::Client client = connect(session.server);
  v1::InteractionResponse response;
  const grpc::Status status = client.call(method, client.interaction(), request, response);
  if (!status.ok()) return refuse(status, session.server);
  print(session, response);
  return kDone;
}

}  // namespace kerf::cli
