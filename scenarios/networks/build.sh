#!/bin/sh
# Makes NAME/NAME.net.xml of the plain XML files beside it. Needs netconvert (pip install eclipse-sumo==1.28.0).
# Usage: PATH=/where/eclipse-sumo/is/bin:$PATH scenarios/networks/build.sh
set -eu
cd "$(dirname "$0")"
for directory in */; do
    name=${directory%/}
    connections=""
    [ ! -f "$name/$name.con.xml" ] || connections="--connection-files $name/$name.con.xml"
    # $connections stays unquoted: it is empty or two words
    netconvert --node-files "$name/$name.nod.xml" --edge-files "$name/$name.edg.xml" $connections \
        --offset.disable-normalization true --no-turnarounds true --roundabouts.guess true --walkingareas true \
        --crossings.guess true --crossings.guess.speed-threshold 16 --junctions.corner-detail 12 \
        --tls.allred.time 3 --junctions.internal-link-detail 24 --junctions.limit-turn-speed 4 --precision 4 --output-file "$name/$name.net.xml"
    sed -i '/^<!-- generated/,/^-->/d' "$name/$name.net.xml"  # a date and local paths
done
