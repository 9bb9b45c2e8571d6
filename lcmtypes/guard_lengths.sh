#!/bin/sh
# lcm-gen's decoders trust the lengths inside a message; a corrupt one allocates gigabytes or reads far beyond
# the message. Two guards: an array has at most one element per byte that is left, and a string ends with
# its only zero (an embedded one could not be encoded again).
exec find "$1" -name '*.hpp' -exec sed -i -E \
  -e 's/^( *)(this->[A-Za-z0-9_]+)\.resize\((this->[A-Za-z0-9_]+)\);$/\1if(\3 < 0 || \3 > maxlen - pos) return -1;\n\1\2.resize(\3);/' \
  -e 's/^( *)if\((__[A-Za-z0-9_]+_len__) > maxlen - pos\) return -1;$/\1if(\2 < 1 || \2 > maxlen - pos) return -1;\n\1if(memchr((const char*)buf + offset + pos, 0, \2) != (const char*)buf + offset + pos + \2 - 1) return -1;/' \
  {} +
