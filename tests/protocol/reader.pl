#!/usr/bin/perl
# Watches a sheet and prints each frame as Wavefront OBJ text with comments, until the stream ends. It is written from
# proto/README.md alone, with nothing but Perl's own modules: where the page lacks something, this cannot be written.
#   reader.pl HOST:PORT sheets/demo
use v5.36;
use IO::Socket::INET;
use List::Util qw(max min);
use MIME::Base64 'encode_base64';
use POSIX 'floor';
use Time::HiRes 'time';

my ($address, $sheet) = @ARGV;
my $socket = IO::Socket::INET->new($address) or die "$address: $@\n";
my ($sequence, $tick, $version, @box, @q, @triangles, @near) = (0, -1, -1);

# A WebSocket, RFC 6455.
sub take($count) {
  (read($socket, my $bytes, $count) // 0) == $count or die "the connection was lost\n";
  return $bytes;
}
sub send_message($opcode, $bytes) {
  my $mask = pack 'N', int rand 2**32;
  my $masked = $bytes ^. substr $mask x (1 + length($bytes) / 4), 0, length $bytes;
  $socket->printflush(pack('CC', 0x80 | $opcode, 0x80 | length $bytes), $mask, $masked);
}
sub receive_message() {
  my ($opcode, $count) = unpack 'CC', take(2);
  $count = unpack 'n', take(2) if $count == 126;
  $count = unpack 'Q>', take(8) if $count == 127;
  return ($opcode & 15, take($count));
}

# Protocol Buffers.
sub varint($n) { return $n < 128 ? chr $n : chr($n & 127 | 128) . varint($n >> 7) }
sub number($field, $value) { return varint($field << 3) . varint($value) }
sub bytes($field, $value) { return varint($field << 3 | 2) . varint(length $value) . $value }
sub fields($message) {
  my %fields;
  my $varint = sub {
    $message =~ s/^([\x80-\xff]*.)//s;
    return unpack 'q', pack 'b64', join '', map { unpack 'b7', $_ } split //, $1;
  };
  while (length $message) {
    my ($field, $type) = map { $_ >> 3, $_ & 7 } $varint->();
    my $value = $type == 0 || $type == 2 ? $varint->() : 0;
    my $bytes = substr $message, 0, (0, 8, $value, 0, 0, 4)[$type], '';
    $fields{$field} = $type == 0 ? $value : $type == 1 ? unpack('d<', $bytes) : ($fields{$field} // '') . $bytes;
  }
  return \%fields;
}

# The numbers that are packed in bytes; with their signs; the ids that they are gaps between.
sub unpacked($bytes, $rows, $columns) {
  my ($bits, @values) = unpack 'b*', $bytes // '';
  my $some = sub ($count) { return oct '0b0' . reverse substr $bits, 0, $count, '' };
  for my $part (0 .. $columns * int(($rows + 15) / 16) - 1) {
    my ($first, $k) = (16 * int($part / $columns), $some->(5));
    for my $at (map { $_ * $columns + $part % $columns } $first .. min($first + 16, $rows) - 1) {
      $values[$at] = $k == 31 ? 0 : $bits =~ s/^1{16}// ? $some->(32) : $bits =~ s/^(1*)0// && length($1) << $k | $some->($k);
    }
  }
  return @values;
}
sub differences { return map { $_ & 1 ? -($_ + 1) / 2 : $_ / 2 } unpacked(@_) }
sub ids($bytes, $count) { my $next = 0; return map { ($next += $_ + 1) - 1 } unpacked($bytes, $count, 1) }

# near_a, near_b and across of each vertex.
sub find_near($num_vertices) {
  my (@found, @lowest, %corners);
  for my $triangle (grep { $_->[0] >= 0 } @triangles) {
    for my $k (0 .. 2) {
      my ($vertex, $from, $to) = @$triangle[$k, $k - 2, $k - 1];
      push @{$corners{"$from $to"}}, $vertex;
      $found[$vertex] //= [$from, $to] if $vertex > max($from, $to);
      $lowest[$vertex] //= min($from, $to) if $vertex > min($from, $to);
    }
  }
  for my $vertex (0 .. $num_vertices - 1) {
    my ($from, $to) = @{$found[$vertex] //= [$lowest[$vertex] // ($vertex ? $vertex - 1 : undef), undef]};
    my @across = map { @{$corners{$_} // []} } defined $to ? ("$from $to", "$to $from") : ();
    push @{$found[$vertex]}, min grep { $_ < $vertex } @across;
  }
  return @found;
}

sub apply_topology($patch, $num_vertices) {
  my ($from, $num_listed) = map { $patch->{$_} // 0 } 1, 9;
  $from == -1 || $from == $version or die "a patch from version $from came at version $version\n";
  @triangles = () if $from == -1;
  my @slots = $from == -1 ? 0 .. $num_listed - 1 : ids($patch->{3}, $num_listed);
  my @corners = differences($patch->{4}, $num_listed, 3);
  for my $i (0 .. $#corners) {
    my ($last, $second, $third) = map { $i < 3 * $_ ? 0 : $corners[$i - 3 * $_] } 1 .. 3;
    $corners[$i] = unpack 'l<', pack 'l<', $corners[$i] + ($from == -1 ? $last + $second - $third : $last);
  }
  $triangles[$slots[$_]] = [@corners[3 * $_ .. 3 * $_ + 2]] for 0 .. $num_listed - 1;
  @near = find_near($num_vertices);
}
sub apply($frame) {
  my ($number, $now, $base_tick, $new_version, $num_vertices) = map { $frame->{$_} // 0 } 1 .. 5;
  $number == $sequence + 1 or die "frame $number came after frame $sequence\n";
  $base_tick == -1 || $base_tick == $tick or die "a delta to tick $base_tick came at tick $tick\n";
  apply_topology(fields($frame->{8}), $num_vertices) if $frame->{8};
  @box = map { my $corner = fields($_); map { $corner->{$_} // 0 } 1 .. 3 } @{fields($frame->{6})}{1, 2} if $frame->{6};
  my @base = $base_tick == -1 ? () : @q;
  @q = differences($frame->{7}, $num_vertices, 3);
  my $way = sub ($at) { return unpack 's<', pack 's<', $q[$at] - $base[$at] };
  for my $i (0 .. $#q) {
    my ($a, $b, $c) = map { defined ? 3 * $_ + $i % 3 : undef } @{$near[$i / 3]};
    my $from_shape = !defined $a || $i < @base ? 0 : defined $c ? $q[$a] + $q[$b] - $q[$c] : $q[$a];
    my $from_motion = !defined $a || $i >= @base ? 0 : floor(($way->($a) + $way->($b // $a)) / 2);
    $q[$i] = $q[$i] + $from_shape + $from_motion + ($base[$i] // 0) & 0xffff;
  }
  ($sequence, $tick, $version) = ($number, $now, $new_version);
}

my $key = encode_base64(pack('N4', map { int rand 2**32 } 1 .. 4), '');
$socket->printflush(join "\r\n", 'GET /watch HTTP/1.1', "Host: $address", 'Upgrade: websocket', 'Connection: Upgrade',
  'Sec-WebSocket-Version: 13', "Sec-WebSocket-Key: $key", 'Sec-WebSocket-Protocol: kerf.v1', '', '');
my $head = '';
$head .= take(1) until $head =~ /\r\n\r\n$/;
$head =~ /^HTTP\/1.1 101 / or die $head;
send_message(2, bytes(1, bytes(1, $sheet)));
STDOUT->autoflush;
while (1) {
  my ($opcode, $message) = receive_message();
  my ($arrived, $response) = (time, $opcode == 2 ? fields($message) : {});
  if ($opcode == 9) { send_message(10, $message) }
  if ($opcode == 8) { say join ' ', '# closed', unpack 'na*', $message; send_message(8, substr $message, 0, 2); last }
  if (my $ended = $response->{3}) { say join ' ', '# ended', @{fields($ended)}{1, 2} }
  next if !$response->{1};
  apply(my $frame = fields($response->{1}));
  my @metres = map { $box[$_ % 3] + $q[$_] * ($box[$_ % 3 + 3] - $box[$_ % 3]) / 65535 } 0 .. $#q;
  my @shown = grep { $_->[0] >= 0 } @triangles;
  say join ' ', '# frame', $sequence, 'tick', $tick, 'base', $frame->{3} // 0, 'topology', $version, 'vertices', @q / 3,
    'triangles', scalar @shown, 'box', @box;
  say sprintf 'v %.17g %.17g %.17g', @metres[3 * $_ .. 3 * $_ + 2] for 0 .. @q / 3 - 1;
  say join ' ', 'f', map { $_ + 1 } @$_ for @shown;
  send_message(2, bytes(2, number(1, $sequence) . number(2, 1 + int 1e6 * (time - $arrived))));
}
