#include "server/service/rpc/rpc_server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <vector>

#include "server/service/api/api.h"
#include "server/service/rpc/services.h"
#include "server/service/rpc/session_reactor.h"

namespace kerf::rpc {
namespace {

constexpr std::size_t kWriterThreads = 2;  // As many as serve HTTP.

// Returns what each connection begins with: TLS 1.2 or later, with a client's certificate where that is needed, or
// nothing.
std::shared_ptr<grpc::ServerCredentials> make_credentials(const std::optional<RpcTls>& tls) {
  if (!tls) return grpc::InsecureServerCredentials();
  grpc::SslServerCredentialsOptions options;
  options.pem_key_cert_pairs.push_back({tls->key, tls->certificate_chain});
  if (!tls->client_authorities.empty()) {
    options.pem_root_certs = tls->client_authorities;
    options.client_certificate_request = GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY;
  }
  return grpc::SslServerCredentials(options);
}

}  // namespace

struct RpcServer::Impl {
  Impl(api::Api& api, host::Clock& clock)
      : writers(kWriterThreads), hosting{writers, clock, api.limits().stream_write_timeout()} {}

  boost::asio::thread_pool writers;
  StreamHosting hosting;
  RpcOptions options;
  int max_request_bytes = 0;
  std::vector<NamedService> services;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> acceptor;
  std::unique_ptr<grpc::Server> server;  // Destroyed before its services.
  std::unique_ptr<ConnectionGate> gate;  // Destroyed before the server.
};

namespace {

void set_limits(grpc::ServerBuilder& builder, const RpcOptions& options, int max_request_bytes) {
  builder.SetMaxReceiveMessageSize(max_request_bytes);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, options.max_streams_per_connection);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, static_cast<int>(options.keepalive_interval.count()));
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, static_cast<int>(options.keepalive_timeout.count()));
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, 5000);
  // Refuses compression: gRPC decompresses a message before it checks its length, and a megabyte can become a thousand.
  builder.AddChannelArgument(GRPC_ARG_ENABLE_PER_MESSAGE_DECOMPRESSION, 0);
  for (const auto algorithm : {GRPC_COMPRESS_DEFLATE, GRPC_COMPRESS_GZIP}) {
    builder.SetCompressionAlgorithmSupportStatus(algorithm, false);
  }
  grpc::ResourceQuota quota("kerfd");
  quota.Resize(options.max_buffer_bytes);
  quota.SetMaxThreads(options.max_reflection_threads);  // Only reflection takes a thread per stream.
  builder.SetResourceQuota(quota);
}

}  // namespace

RpcServer::RpcServer(api::Api& api, host::Clock& clock, const RpcOptions& options)
    : impl_(std::make_unique<Impl>(api, clock)) {
  impl_->options = options;
  impl_->max_request_bytes = api.limits().max_request_bytes;
  impl_->services =
      make_services(api, {clock, {options.transfer_silence_timeout, options.transfer_timeout}}, impl_->hosting);
}

RpcServer::~RpcServer() {
  stop(std::chrono::milliseconds(0));
}

Result<int> RpcServer::start(const std::string& address) {
  impl_->gate = std::make_unique<ConnectionGate>(
      GateLimits{impl_->options.max_connections, impl_->options.max_connections_per_address,
                 impl_->options.first_byte_timeout},
      [impl = impl_.get()](int descriptor) {
        grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
        connection.fd = descriptor;
        impl->acceptor->HandleNewConnection(&connection);
      });
  KERF_TRY_ASSIGN(const int port, impl_->gate->bind(address));
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  set_limits(builder, impl_->options, impl_->max_request_bytes);
  using Builder = grpc::ServerBuilder::experimental_type;
  impl_->acceptor = builder.experimental().AddExternalConnectionAcceptor(Builder::ExternalConnectionType::FROM_FD,
                                                                         make_credentials(impl_->options.tls));
  for (const NamedService& named : impl_->services) builder.RegisterService(named.service.get());
  impl_->server = builder.BuildAndStart();
  if (!impl_->server) return internal_error("INTERNAL", "gRPC could not be started");
  for (const NamedService& named : impl_->services) {
    impl_->server->GetHealthCheckService()->SetServingStatus(named.name, true);
  }
  impl_->gate->open();
  return port;
}

void RpcServer::drain() {
  if (impl_->server) impl_->server->GetHealthCheckService()->SetServingStatus(false);
}

void RpcServer::stop(std::chrono::milliseconds grace) {
  if (!impl_->server) return;
  impl_->gate->stop();
  impl_->server->Shutdown(std::chrono::system_clock::now() + grace);
  impl_->server->Wait();
  impl_->server.reset();
}

GateCounts RpcServer::connections() const {
  return impl_->gate ? impl_->gate->counts() : GateCounts();
}

}  // namespace kerf::rpc
