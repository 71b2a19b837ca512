#include "server/service/host/listening.h"

#include <utility>

#include <boost/asio/error.hpp>
#include <boost/asio/ip/v6_only.hpp>

namespace kerf::host {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using NetError = boost::system::error_code;

// Number of tries with port 0: a port free at one address may be taken at another.
constexpr int kTries = 16;

// `is_alone`: there is no other address to listen at, so an IPv6 one may also serve IPv4.
tcp::acceptor listen_at(const tcp::endpoint& endpoint, bool is_alone, const asio::any_io_executor& executor,
                        NetError& error) {
  tcp::acceptor acceptor(executor);
  acceptor.open(endpoint.protocol(), error);
  const bool is_v6 = endpoint.protocol() == tcp::v6();
  if (!error && is_v6 && !is_alone) acceptor.set_option(asio::ip::v6_only(true), error);
  // Lets a restarted server have its port back at once; a port that another program listens on is still refused.
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  return acceptor;
}

Listening listen_once(const tcp::resolver::results_type& addresses,
                      const std::function<asio::any_io_executor()>& make_executor) {
  Listening listening;
  NetError last;
  for (const auto& entry : addresses) {
    tcp::endpoint endpoint = entry.endpoint();
    if (!listening.acceptors.empty()) endpoint.port(listening.acceptors.front().local_endpoint().port());
    tcp::acceptor acceptor = listen_at(endpoint, addresses.size() == 1, make_executor(), last);
    if (!last) listening.acceptors.push_back(std::move(acceptor));
    if (last == asio::error::address_in_use) return {{}, last};
  }
  if (listening.acceptors.empty()) listening.error = last;
  return listening;
}

}  // namespace

Listening listen_at_each(const std::string& host, int port,
                         const std::function<asio::any_io_executor()>& make_executor) {
  NetError error;
  const auto addresses =
      tcp::resolver(make_executor()).resolve(host, std::to_string(port), tcp::resolver::passive, error);
  if (error) return {{}, error};
  if (addresses.empty()) return {{}, asio::error::host_not_found};
  Listening listening = listen_once(addresses, make_executor);
  for (int i = 1; i < kTries && port == 0 && listening.error == asio::error::address_in_use; ++i) {
    listening = listen_once(addresses, make_executor);
  }
  return listening;
}

}  // namespace kerf::host
