#pragma once

#include <functional>
#include <string>
#include <vector>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/system/error_code.hpp>

namespace kerf::host {

struct Listening {
  std::vector<boost::asio::ip::tcp::acceptor> acceptors;  // Empty if `error` is set.
  boost::system::error_code error;
};

// Listens at each address of `host`, a name or an address without brackets, at the same port. Port 0 picks one that is
// free at all of them. Fails if one of them is taken, or if this machine has none of the addresses. Addresses of an
// unsupported family are skipped. `make_executor` gives each acceptor its executor.
Listening listen_at_each(const std::string& host, int port,
                         const std::function<boost::asio::any_io_executor()>& make_executor);

}  // namespace kerf::host
