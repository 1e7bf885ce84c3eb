"""The master's answers go in; when it has come back without knowing us, everything is registered with it anew."""

from __future__ import annotations

import http.client
import threading
import time
import xmlrpc.client
from collections.abc import Callable
from typing import Any

from limner.ros.middleware import ros

LOOK_S = 1.0
_ROUNDS = 2


def keep_registered(told: Callable[[str], None]) -> None:
    """Watch the master from a thread until ROS ends, since rospy registers a node only once.

    Args:
        told: that it went away, and that it is back.
    """
    threading.Thread(target=_watch, args=(told,), daemon=True).start()


def _watch(told: Callable[[str], None]) -> None:
    away, rounds = False, 0
    while not ros().rospy.is_shutdown():
        time.sleep(LOOK_S)
        try:
            known = _known()
            # Twice: a list of publishers that is older than the master's own last word undoes it, and the first name
            # that is registered makes a node known whose others are not.
            rounds = rounds if known else _ROUNDS
            if rounds and not ros().rospy.is_shutdown():
                _register()
                rounds -= 1
        except (OSError, http.client.HTTPException, xmlrpc.client.Error):
            if not away:
                told("the ROS master is gone; what is connected goes on, nobody new finds us")
            away = True
            continue
        if away or not known:
            told("the ROS master is back; registered with it again")
        away = False


def _known() -> bool:
    name = ros().rospy.get_name()
    code, _, uri = _master().lookupNode(name, name)
    return bool(code == 1 and uri == ros().rospy.get_node_uri())


def _register() -> None:
    """Register topics and services of this node; publishers that are there already are connected to."""
    rospy = ros().rospy
    name, uri, master = rospy.get_name(), rospy.get_node_uri(), _master()
    topics = rospy.topics.get_topic_manager()
    for topic, kind in topics.get_publications():
        master.registerPublisher(name, topic, kind, uri)
    for topic, kind in topics.get_subscriptions():
        _, _, publishers = master.registerSubscriber(name, topic, kind, uri)
        if publishers:
            xmlrpc.client.ServerProxy(uri).publisherUpdate("/master", topic, publishers)
    services = rospy.impl.registration.get_service_manager()
    for service, address in services.get_services():
        master.registerService(name, service, address, uri)


def _master() -> Any:
    return xmlrpc.client.ServerProxy(ros().rosgraph.get_master_uri())
