#!/bin/sh
# lcm-gen's decoders trust an array's length before looking at what is left of the message: a corrupt
# length allocates gigabytes. Every element takes at least a byte, so no more than what is left can be true.
exec find "$1" -name '*.hpp' -exec sed -i -E \
  's/^( *)(this->[A-Za-z0-9_]+)\.resize\((this->[A-Za-z0-9_]+)\);$/\1if(\3 < 0 || \3 > maxlen - pos) return -1;\n\1\2.resize(\3);/' {} +
