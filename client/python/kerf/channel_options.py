"""Options of channels to servers."""

# A message may hold the exact state of half a million vertices. Proxies set in the environment are ignored, because
# Kerf servers are near. A server that is back is found within 2 s: gRPC tries again as soon after a failure, and looks
# up the address before each try, which it would otherwise do every 30 s.
CHANNEL_OPTIONS = [
    ("grpc.max_receive_message_length", 256 << 20),
    ("grpc.enable_http_proxy", 0),
    ("grpc.initial_reconnect_backoff_ms", 250),
    ("grpc.max_reconnect_backoff_ms", 1000),
    ("grpc.dns_min_time_between_resolutions_ms", 500),
]
