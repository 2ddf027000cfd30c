#!/bin/sh
# {{what}}, whose number is given.
set -eu
stickslip={{program}}
run={{run}}
exec "$stickslip" submit "$run/job.toml" --out "$run" --shard "$1/{{shards}}"{{threads}}{{options}}
