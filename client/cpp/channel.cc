#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>
#include <grpcpp/support/client_interceptor.h>

#include "client/cpp/credentials.h"

namespace kerf::client {
namespace {

// Adds the token to a call as it begins.
class TokenSender : public grpc::experimental::Interceptor {
 public:
  explicit TokenSender(const std::string& authorization) : authorization_(authorization) {}
  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(grpc::experimental::InterceptionHookPoints::PRE_SEND_INITIAL_METADATA)) {
      methods->GetSendInitialMetadata()->emplace("authorization", authorization_);
    }
    methods->Proceed();
  }

 private:
  const std::string& authorization_;
};

// Makes the TokenSender of each call. The channel owns it, and so it outlives them.
class TokenSenders : public grpc::experimental::ClientInterceptorFactoryInterface {
 public:
  explicit TokenSenders(const std::string& token) : authorization_("Bearer " + token) {}
  grpc::experimental::Interceptor* CreateClientInterceptor(grpc::experimental::ClientRpcInfo* /*call*/) override {
    return new TokenSender(authorization_);  // gRPC deletes it.
  }

 private:
  const std::string authorization_;
};

std::shared_ptr<grpc::ChannelCredentials> channel_credentials(const Secrets& secrets) {
  if (!secrets.use_tls) return grpc::InsecureChannelCredentials();
  grpc::SslCredentialsOptions options;
  options.pem_root_certs = secrets.authorities;
  options.pem_private_key = secrets.key;
  options.pem_cert_chain = secrets.certificate;
  return grpc::SslCredentials(options);
}

}  // namespace

std::shared_ptr<grpc::Channel> open_channel(const std::string& address, const Secrets& secrets,
                                            Client::Connection connection) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(Client::kMaxReceiveBytes);
  // Ignores proxies set in the environment: Kerf servers are near, and a buffering proxy would spoil the stream.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  // Finds a restarted server within 2 s. gRPC looks up the address before each try, else only every 30 s.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 250);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 1000);
  arguments.SetInt(GRPC_ARG_DNS_MIN_TIME_BETWEEN_RESOLUTIONS_MS, 500);
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, connection == Client::Connection::kOwn ? 1 : 0);
  if (!secrets.tls_name.empty()) arguments.SetSslTargetNameOverride(secrets.tls_name);
  std::vector<std::unique_ptr<grpc::experimental::ClientInterceptorFactoryInterface>> interceptors;
  if (!secrets.token.empty()) interceptors.push_back(std::make_unique<TokenSenders>(secrets.token));
  return grpc::experimental::CreateCustomChannelWithInterceptors(address, channel_credentials(secrets), arguments,
                                                                 std::move(interceptors));
}

}  // namespace kerf::client
