"""A client of rosbridge that is not ours: listens to a controller's topic and prints each message on a line.

python rosbridge_listener.py PORT TOPIC TYPE
"""

import json
import sys

import roslibpy


def say(line):
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


port, topic, kind = sys.argv[1:]
ros = roslibpy.Ros("127.0.0.1", int(port))
ros.run(timeout=10)
roslibpy.Topic(ros, topic, kind).subscribe(lambda message: say(json.dumps(dict(message))))
say("ready")
sys.stdin.read()
ros.terminate()
